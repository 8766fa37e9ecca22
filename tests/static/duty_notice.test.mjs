// Who is told what when somebody is responsible for a robot no longer, or is asked to be.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const source = fs.readFileSync(new URL('../../static/js/ui/duty_notice.js', import.meta.url), 'utf8');

function page(user, rights, screen = 'operate') {
  const said = [];
  let hear = null;
  const HL = { config: { user: { id: user }, rights }, view: { screen }, toast: (words) => said.push(words) };
  vm.runInContext(source, vm.createContext({ HL, window: { headland: { on: (_topic, fn) => (hear = fn) } } }));
  return (told) => (said.splice(0), hear({ kind: 'duty', names: ['Weeder 01', 'Weeder 02'], by: 'Martha Keller', by_id: 'operator', ...told }), said.join());
}

test('robots that nobody is responsible for any more are told to who may take them, on every screen', () => {
  const freed = { what: 'released', from_users: ['operator'] };
  assert.equal(page('supervisor', ['take_lease'])(freed), 'Nobody is responsible for Weeder 01, Weeder 02 any more.');
  assert.equal(page('dispatcher', ['pause'])(freed), '');
  assert.equal(page('operator', ['pause'])(freed), '', 'who did it knows');
  assert.equal(page('operator', ['pause'])({ ...freed, by: 'Ada', by_id: '' }), 'You are no longer responsible for Weeder 01, Weeder 02.');
  assert.equal(page('supervisor', ['take_lease'])({ ...freed, names: [] }), '', 'they were taken out of the list');
  const many = Array.from({ length: 9 }, (_, n) => `W${n}`);
  assert.equal(page('supervisor', ['take_lease'])({ ...freed, names: many }), 'Nobody is responsible for W0, W1, W2 and 6 more any more.');
});

test('who loses robots to a supervisor, is asked, or is left with them, is told', () => {
  const martha = page('operator', ['pause']);
  const by = { by: 'Anna Ostermeier', by_id: 'supervisor' };
  assert.equal(martha({ ...by, what: 'taken', from_users: ['operator'] }), 'Anna Ostermeier is responsible for Weeder 01, Weeder 02 now, no longer you.');
  assert.equal(martha({ ...by, what: 'taken', from_users: [] }), '');
  assert.equal(martha({ ...by, what: 'offered', to_user: 'operator' }), 'Anna Ostermeier hands over Weeder 01, Weeder 02 to you. Take over on Fleet.');
  assert.equal(page('operator', ['pause'], 'fleet')({ ...by, what: 'offered', to_user: 'operator' }), '', 'Fleet shows the offer itself');
  assert.equal(martha({ ...by, what: 'declined', to_user: 'operator' }), 'Anna Ostermeier does not take over Weeder 01, Weeder 02. It stays as it was.');
});
