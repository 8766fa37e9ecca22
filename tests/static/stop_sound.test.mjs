// STOP's own tones: what others give way to. They see it by `sounding`.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

function sound() {
  const window = { addEventListener() {} };
  vm.runInContext(fs.readFileSync(new URL('../../static/js/stop_sound.js', import.meta.url), 'utf8'), vm.createContext({ window, navigator: {} }));
  return new window.headlandStopParts.Sound();
}

test('a stop under way is named with the time to its next tone', () => {
  const stop = sound();
  assert.equal(stop.sounding(0), null);
  stop.follow('not-confirmed', 1000, true);
  assert.equal(stop.sounding(1100).state, 'not-confirmed');
  assert.equal(stop.sounding(1100).inMs, 0);
  assert.equal(stop.sounding(2000).inMs, 1000);
});

test('a tone that sounds once is over when it is over', () => {
  const stop = sound();
  stop.follow('standstill', 1000, true);
  assert.equal(stop.sounding(1300).state, 'standstill');
  assert.equal(stop.sounding(1600), null);
});

test('what is silenced gives way', () => {
  const stop = sound();
  stop.follow('no-link', 1000, true);
  stop.silence(2000, 120000);
  assert.equal(stop.sounding(3000), null);
  assert.equal(stop.sounding(122001).state, 'no-link');
});

test('a state that was there when the page opened makes no tone', () => {
  const stop = sound();
  stop.follow('no-link', 1000, false);
  assert.equal(stop.sounding(1100), null);
});
