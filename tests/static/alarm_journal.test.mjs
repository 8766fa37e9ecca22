// What an export says when the file does not come whole, without a page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const source = readFileSync(new URL('../../static/js/ui/alarm_journal.js', import.meta.url), 'utf8');

async function exported(answer) {
  const said = [];
  const node = { click() {}, remove() {} };
  const HL = { el: () => node, records: {}, config: { apiPath: '/api/v1' }, toast: (words, sign) => said.push([words, sign]) };
  const fetch = async () => answer;
  vm.runInContext(source, vm.createContext({ HL, fetch, URL: { createObjectURL: () => 'blob:1', revokeObjectURL() {} }, URLSearchParams, Date, setTimeout: () => 0, document: { body: { append() {} } } }));
  await new HL.AlarmJournal(() => ({})).export();
  return said;
}

test('a file that breaks off on the way is not called saved', async () => {
  const broken = { ok: true, blob: () => Promise.reject(new TypeError('network error')) };
  assert.deepEqual(await exported(broken), [['Journal not exported: the server did not give all of it. Try again.', 'block']]);
});

test('a whole one is', async () => {
  assert.deepEqual(await exported({ ok: true, blob: async () => ({}) }), [['Journal saved as a CSV file.', 'download']]);
});
