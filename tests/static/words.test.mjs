// Times as people read them.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const context = vm.createContext({ HL: {}, Date });
vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/words.js', import.meta.url), 'utf8'), context);
const { date, day } = context.HL.words;
const inDays = (days) => { const date = new Date(); date.setDate(date.getDate() + days); date.setHours(7, 5, 0, 0); return date; };

test('an hour of another day says which day', () => {
  assert.equal(day(inDays(0)), '07:05');
  const tomorrow = inDays(1);
  assert.equal(day(tomorrow), `${['Sun', 'Mon', 'Tue', 'Wed', 'Thu', 'Fri', 'Sat'][tomorrow.getDay()]} 07:05`);
  const later = inDays(9);
  assert.equal(day(later), `${later.getDate()} ${later.toLocaleDateString('en-GB', { month: 'short' })} 07:05`);
});

test('a date has the name of its month', () => assert.equal(date(new Date(2026, 3, 9)), '9 Apr 2026'));
