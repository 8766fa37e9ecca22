// What STOP ALL claims before anybody presses.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const window = {};
vm.runInContext(fs.readFileSync(new URL('../../static/js/stop_words.js', import.meta.url), 'utf8'), vm.createContext({ window }));
const { all, segment } = window.headlandStopParts.words;

test('with nobody to stop it does not promise to send', () => {
  const none = all({ state: 'no-link', total: 0, standing: 0, linked: 0, failing: [] }, 0);
  assert.equal(none.join('|'), 'STOP ALL|No robots|none heard|true');
  const silent = all({ state: 'no-link', total: 3, standing: 0, linked: 0, failing: [] }, 0);
  assert.equal(silent[2], 'NO LINK · sends anyway');
});

test('the segment says whom it stops, also while one is not confirmed', () => {
  assert.equal(segment({ state: 'not-confirmed', total: 24, standing: 23, failing: ['Planter 03'] }).join('|'), 'All 24|1 not conf.');
});
