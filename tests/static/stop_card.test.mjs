// What the card of one press says, row by row, of a robot that does not answer.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const read = (name) => fs.readFileSync(new URL(`../../static/js/${name}.js`, import.meta.url), 'utf8');

// the words that were drawn into the rows, from a document that keeps nothing else
function said(step) {
  const element = (tag, attributes = {}, ...children) => {
    const node = { tag, children: [], dataset: {}, words: '', isConnected: true, classList: { toggle: () => {} }, remove: () => {}, replaceWith: () => {}, setAttribute: () => {} };
    node.append = (...more) => node.children.push(...more);
    node.replaceChildren = (...more) => (node.children = more);
    for (const [name, at] of [['firstChild', 0], ['lastChild', -1]]) Object.defineProperty(node, name, { get: () => node.children.at(at) });
    node.append(...children);
    return node;
  };
  const window = { headlandStopParts: { element, attribute: () => {}, text: (node, words) => (node.words = words) } };
  const document = { createElementNS: (_, tag) => element(tag) };
  const context = vm.createContext({ window, document });
  vm.runInContext(read('stop_words'), context);
  vm.runInContext(read('stop_card'), context);
  const mount = element('div');
  const robots = [{ id: 'weeder-07', name: 'Weeder 07', step: { by: 'Martha Keller', device: 'Tablet 3', pressed_utc: '2026-11-23T06:00:00Z', at: 0, count: 5, ...step } }];
  window.headlandStopParts.card(mount, { robots, scope: { id: 'weeder-07' } }, {}, 2000);
  return mount.headlandCard.list.children.map((row) => [row.children[1].firstChild.words, row.children[1].lastChild.words]);
}

test('what is missing is said once, with the time in which it was due', () => {
  const rows = said({ state: 'not-confirmed', sent_ms: 20, paths: { mqtt: true, http: true }, text: 'No acknowledgement within 1.0 s.' });
  assert.deepEqual(rows[1], ['SENT', '5 times, by radio network and directly']);
  assert.deepEqual(rows[2], ['No acknowledgement', 'expected within 1.0 s']);
  const moving = said({ state: 'not-confirmed', sent_ms: 20, ack_ms: 90, paths: { http: true }, text: 'No standstill within 2.4 s.' });
  assert.deepEqual(moving[3], ['Standstill unknown', 'expected within 2.4 s']);
});

test('what the robot itself answered stands as it is', () => {
  const rows = said({ state: 'not-confirmed', sent_ms: 20, paths: { mqtt: true }, text: 'Safety controller is off.' });
  assert.deepEqual(rows[2], ['No acknowledgement', 'Safety controller is off.']);
});
