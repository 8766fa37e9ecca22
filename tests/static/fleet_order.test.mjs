// What a robot's row says and where it stands: the rules of the fleet list, without a page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const HL = {};
vm.runInContext(readFileSync(new URL('../../static/js/ui/fleet_order.js', import.meta.url), 'utf8'), vm.createContext({ HL, Intl, Map, Set }));
const { judge, isMoved, worstAlarms, notices, sections, passes, hold, figures, advice } = HL.fleetOrder;
const words = { since: (ms) => `${Math.floor(ms / 1000)} s` };

const usual = { name: 'Weeder 01', family: 'weeder', mode: 'auto', text: 'Running', task: 'Row 12/60', is_online: true, is_registered: true, level: null, why: '', waits: false, help_s: null, since: null, mission: { status: 'running', name: 'M-1' }, field: 'Nordfeld' };
const of = (id, robot = {}, more = {}) => {
  const whole = { ...usual, name: id, ...robot };
  const given = { ageMs: 200, words, ...more };
  return { id, robot: whole, ageMs: given.ageMs, duty: more.duty, verdict: judge(whole, given) };
};
const ids = (section) => section.items.map((one) => one.id);
const plain = (value) => JSON.parse(JSON.stringify(value));
const alarm = (source, priority, state = 'unacknowledged', raised = 1) => ({ source, priority, state, raised, t: raised, title: `A${priority}`, text: 'so now' });

test('needs you holds critical, high and whoever waits for a person; watch the rest that is not normal', () => {
  const [needs, watch, normal] = sections([
    of('p1', { level: 1 }), of('p2', { level: 2 }), of('p3', { level: 3 }), of('p4', { level: 4 }), of('ok'),
    of('asks', { waits: true, why: 'Weed unsure.', mode: 'paused' }), of('gone', { is_online: false }), of('new', { is_registered: false }),
  ]);
  assert.deepEqual(plain(ids(needs)), ['p1', 'gone', 'p2', 'asks']);
  assert.deepEqual(plain(ids(watch)), ['p3', 'new', 'p4']);
  assert.deepEqual(plain(ids(normal)), ['ok']);
});

test('within a priority the one that needs help sooner comes first, then who waits longest, then by name', () => {
  const [needs] = sections([
    of('later', { level: 2, help_s: 600 }), of('sooner', { level: 2, help_s: 60 }), of('unknown', { level: 2 }),
    of('since-9', { level: 2, help_s: 60, since: 9 }), of('since-5', { level: 2, help_s: 60, since: 5 }), of('now', { level: 2, waits: true, help_s: 600 }),
  ]);
  assert.deepEqual(plain(ids(needs)), ['now', 'since-5', 'since-9', 'sooner', 'later', 'unknown']);
});

test('names are ordered as people count', () => {
  const [all] = sections([of('Weeder 10'), of('Weeder 9'), of('Weeder 1')], { sort: 'name' });
  assert.deepEqual(plain(ids(all)), ['Weeder 1', 'Weeder 9', 'Weeder 10']);
});

test('a stop that is not confirmed outranks everything the robot said', () => {
  const { verdict } = of('a', { level: null }, { stop: { state: 'not-confirmed', t: 5 }, alarm: alarm('a', 2) });
  assert.equal(verdict.level, 1);
  assert.equal(verdict.head, 'Stop not confirmed');
  assert.equal(verdict.group, 'needs-you');
});

test('a robot that is silent says for how long, and its old state is not shown as news', () => {
  const { verdict } = of('a', { task: 'Row 12/60' }, { ageMs: 12000 });
  assert.deepEqual([verdict.level, verdict.head, verdict.group], [2, 'No link for 12 s', 'needs-you']);
  assert.equal(of('b', { is_online: false }, { ageMs: Infinity }).verdict.head, 'Never heard');
});

test('the worst active alarm is joined; shelved and suppressed ones are not', () => {
  const worst = worstAlarms({
    x: alarm('a', 3), y: alarm('a', 2, 'acknowledged', 5), z: alarm('a', 2, 'unacknowledged', 9), s: alarm('a', 1, 'shelved'), o: alarm('b', 1, 'out_of_service'), n: null,
  });
  assert.equal(worst.a.id, 'z');
  assert.equal(worst.b, undefined);
  const { verdict } = of('a', { level: 4 }, { alarm: worst.a });
  assert.deepEqual([verdict.level, verdict.head, verdict.look, verdict.since], [2, 'A2', 'unacknowledged', 9]);
});

test('one sentence: why, what clears it, who can, how long it takes', () => {
  const { verdict } = of('a', { waits: true, mode: 'stopped', level: 3, why: 'Martha pressed STOP.', clears: 'Reset the stop, then resume.', who: 'operator', takes_s: 60 });
  assert.equal(verdict.head, 'Martha pressed STOP.');
  assert.equal(verdict.line, 'Reset the stop, then resume. Who: operator. about 1 min');
  assert.equal(advice({ clears: 'It is ready when charged.', who: 'nobody', takes_s: null }), 'It is ready when charged');
});

test('a robot at work that needs somebody soon is watched before it stands', () => {
  const { verdict } = of('a', { help_s: 600 });
  assert.deepEqual([verdict.group, verdict.level, verdict.head], ['watch', 4, 'Needs somebody in 10 min']);
  assert.equal(of('b', { help_s: 3600 }).verdict.group, 'normal');
});

test('search looks at name, id, field, mission and what is wrong; all words must fit', () => {
  const item = of('weeder-07', { name: 'Weeder 07', field: 'Nordfeld 12' });
  for (const q of ['weeder', '07 nord', 'm-1', 'ROW']) assert.ok(passes(item, { q }), q);
  assert.ok(!passes(item, { q: 'weeder south' }));
});

test('filters narrow by kind, group, state and whose robots they are', () => {
  const item = of('a', {}, { duty: { user: 'martha' } });
  const groups = [{ id: 'g', robots: ['a'] }, { id: 'other', robots: ['b'] }];
  assert.ok(passes(item, { families: ['weeder'], group: 'g', mine: true, state: 'working' }, { me: 'martha', groups }));
  assert.ok(!passes(item, { families: ['uav'] }));
  assert.ok(!passes(item, { mine: true }, { me: 'anna' }));
  assert.ok(!passes(item, { group: 'other' }, { groups }));
  assert.ok(passes(item, { group: 'deleted' }, { groups }), 'a group that is not known hides nobody');
  assert.ok(!passes(item, { state: 'offline' }));
  assert.ok(passes(of('b', { is_online: false }), { state: 'offline' }));
});

test('above 200 robots those that need nobody fold into groups with counts', () => {
  const many = Array.from({ length: 300 }, (_, i) => of(`r-${i}`, { field: i % 2 ? 'East' : 'West', level: i === 7 ? 1 : null }));
  const found = sections(many);
  assert.deepEqual(plain(found.map((s) => [s.title, s.items.length, s.count ?? null])), [['Needs you', 1, null], ['Watch', 0, null], ['Normal', 0, 299], ['East', 0, 149], ['West', 0, 150]]);
  assert.equal(sections(many, { open: new Set(['in-East']) })[3].items.length, 149);
});

test('rows hold still under the pointer: they change what they say, not where they stand', () => {
  const before = sections([of('a'), of('b'), of('c', { level: 2 })]);
  const now = sections([of('a', { level: 1 }), of('b'), of('d')]);
  const held = hold(before, now);
  assert.deepEqual(plain(held.sections.map(ids)), [[], [], ['a', 'b', 'd']]);
  assert.equal(held.sections[2].items[0].verdict.level, 1);
  assert.equal(held.moved, 1);
});

test('a silent robot whose stop is not confirmed is not drawn as heard', () => {
  const robot = { id: 'planter-03', rtt_ms: 4, is_online: true };
  const stop = { state: 'not-confirmed', t: 1 };
  const seen = (ageMs) => judge(robot, { ageMs, stop, words });
  assert.deepEqual(plain([seen(200), seen(20000)].map(({ head, isLost, group }) => [head, isLost, group])), [['Stop not confirmed', false, 'needs-you'], ['Stop not confirmed', true, 'needs-you']]);
});

test('the strip counts what works now and names the slowest link and the oldest datum of those heard', () => {
  const strip = figures([of('a', { rtt_ms: 80 }), of('b', { rtt_ms: 110 }, { ageMs: 900 }), of('c', { mode: 'idle' }), of('d', { is_online: false, rtt_ms: 9000 }, { ageMs: 60000 })]);
  assert.deepEqual(plain(strip), { total: 4, working: 2, offline: 1, slowestMs: 110, oldestMs: 900, newestMs: 200, planters: false });
});

test('a place in the list moves by level and group, and by waiting only where somebody is needed', () => {
  const calm = of('a', { help_s: 5000 }).verdict;
  assert.equal(isMoved(calm, of('a', { help_s: 4000, task: 'Row 13/60' }).verdict), false);
  assert.equal(isMoved(calm, of('a', { help_s: 600 }).verdict), true);
  assert.equal(isMoved(of('a', { level: 2, since: 5 }).verdict, of('a', { level: 2, since: 6 }).verdict), true);
});

test('what an alarm says besides its title is told, its title is not told twice', () => {
  const line = (title, text) => of('a', {}, { alarm: { ...alarm('a', 3), title, text } }).verdict.line;
  assert.equal(line('Crane outside its limit', 'The crane is outside its limit: joint 3 at 97 %.'), 'Joint 3 at 97 %.');
  assert.equal(line('Position not exact', 'Position not exact.'), '');
  assert.equal(line('Cover open', 'RTK: float.'), 'RTK: float.');
});

test('an alarm whose cause is gone says so, and gives way to what the robot needs now', () => {
  const gone = { ...alarm('a', 2, 'returned'), title: 'No data link' };
  const over = of('a', {}, { alarm: gone }).verdict;
  assert.deepEqual([over.head, over.level, over.look, over.group], ['No data link: over', 2, 'returned', 'watch']);
  const asks = of('a', { waits: true, why: 'It cannot tell crop and weed apart.', clears: 'Look at the row.' }, { alarm: gone }).verdict;
  assert.deepEqual([asks.head, asks.line], ['It cannot tell crop and weed apart.', 'Look at the row. No data link: over. Nobody has acknowledged it.']);
});

test('advice about another cause than the alarm comes with its reason', () => {
  const robot = { waits: true, why: 'A person is 4 m ahead.', clears: 'It goes on when the person has left.' };
  const line = (title, text) => of('a', robot, { alarm: { ...alarm('a', 2), title, text } }).verdict.line;
  assert.equal(line('Battery low', '18 % left.'), 'A person is 4 m ahead. It goes on when the person has left. 18 % left.');
  assert.equal(line('Person ahead', 'A person is 4 m ahead.'), 'It goes on when the person has left. A person is 4 m ahead.');
});

test('alarms of the console and of stations need somebody too, and no alarm of a robot stands twice', () => {
  const found = notices({
    'gateway-down.console': { ...alarm('console', 1), name: 'Headland', title: 'STOP service down' }, 'disk-full.console': { ...alarm('console', 2, 'acknowledged'), name: 'Headland' },
    'station.s1': { ...alarm('s1', 3), name: 'Mast' }, 'over.console': { ...alarm('console', 2, 'returned'), name: 'Headland' }, 'aside.console': { ...alarm('console', 1, 'shelved') }, 'link.w': alarm('w', 1),
  }, { w: {} });
  assert.deepEqual(plain(found.map((one) => one.id)), ['gateway-down.console', 'disk-full.console']);
  assert.equal(found[0].verdict.head, 'STOP service down');
  const [needs, , normal] = sections([of('ok'), of('p2', { level: 2 })], { notices: found });
  assert.deepEqual(plain(ids(needs)), ['gateway-down.console', 'disk-full.console', 'p2']);
  assert.equal(normal.count, 1);
  for (const sort of ['name', 'group']) assert.deepEqual(plain(ids(sections([of('ok')], { sort, notices: found })[0])), ['gateway-down.console', 'disk-full.console']);
  assert.deepEqual(plain(notices(null, {})), []);
});

test('what nobody answered stands first of its priority and names who is responsible', () => {
  const told = { ...alarm('told', 2), id: 'x', escalated: 7 };
  const [needs] = sections([of('sooner', { help_s: 60 }, { alarm: alarm('sooner', 2) }), of('told', {}, { alarm: told, responsible: 'Martha Keller' }), of('top', {}, { alarm: alarm('top', 1) })]);
  assert.deepEqual(plain(ids(needs)), ['top', 'told', 'sooner']);
  assert.equal(needs.items[1].verdict.line, 'Nobody answered, responsible: Martha Keller. so now');
  assert.equal(of('a', {}, { alarm: { ...told, state: 'acknowledged' } }).verdict.isUnanswered, false);
  assert.equal(worstAlarms({ x: alarm('a', 2, 'unacknowledged', 1), y: { ...alarm('a', 2, 'unacknowledged', 9), escalated: 9 } }).a.id, 'y');
});

test('an alarm that is over hides none that is so now, also if nobody answered it', () => {
  const over = { ...alarm('a', 2, 'returned', 1), title: 'No data link', escalated: 5 };
  const now = { ...alarm('a', 2, 'unacknowledged', 9), title: 'Off its line' };
  const found = of('a', {}, { alarm: worstAlarms({ over, now }).a }).verdict;
  assert.deepEqual([found.head, found.group], ['Off its line', 'needs-you']);
  const gone = of('gone', {}, { alarm: { ...over, priority: 1 } });
  const live = of('live', {}, { alarm: { ...now, source: 'live', priority: 1 } });
  const [needs] = sections([gone, live]);
  assert.deepEqual(plain(ids(needs)), ['live', 'gone']);
  assert.equal(isMoved(of('gone', {}, { alarm: { ...over, priority: 1, state: 'unacknowledged' } }).verdict, gone.verdict), true);
});

const stopped = { mode: 'stopped', level: 3, waits: true, code: 'stop_latched', why: 'Anna pressed STOP. Laser off, tracks brake.', clears: 'Reset the stop, then resume.', who: 'operator', takes_s: 60 };

test('while it may move or its tool is on, the sentence is what the alarm says to do and nothing the robot says of itself', () => {
  const steps = ['Use the red button on the machine', 'Keep everyone away from it'];
  for (const code of ['stop-not-confirmed', 'moves-after-stop', 'tool-on-unasked', 'outside-fence']) {
    const { verdict } = of('a', stopped, { alarm: { ...alarm('a', 1), code, title: 'Moves although it was stopped', text: 'It is stopped and moves at 0.8 m/s.', steps } });
    assert.equal(verdict.line, 'Use the red button on the machine. Keep everyone away from it. It is stopped and moves at 0.8 m/s.');
  }
});

test('a silent robot keeps its alarm of priority 1, and nobody is sent to it for its radio', () => {
  const critical = { ...alarm('a', 1), id: 'x', code: 'moves-after-stop', title: 'Moves although it was stopped', text: 'It is stopped and moves at 0.8 m/s.', steps: ['Use the red button on the machine', 'Keep everyone away from it'] };
  const { verdict } = of('a', { ...stopped, is_online: false }, { ageMs: 20000, alarm: critical });
  assert.deepEqual([verdict.level, verdict.head, verdict.look, verdict.group, verdict.isLost], [1, 'Moves although it was stopped', 'unacknowledged', 'needs-you', true]);
  assert.equal(verdict.line, 'No link for 20 s. Use the red button on the machine. Last heard: It is stopped and moves at 0.8 m/s.');
  const over = of('a', { ...stopped, is_online: false }, { ageMs: 20000, alarm: { ...critical, state: 'returned' } }).verdict;
  assert.deepEqual([over.head, over.line], ['No link for 20 s', 'Look before you walk up to it. Moves although it was stopped: over. Nobody has acknowledged it.']);
  const asks = of('a', { is_online: false }, { ageMs: 20000, alarm: { ...alarm('a', 2), code: 'person-ahead' } }).verdict;
  assert.deepEqual([asks.head, asks.look], ['No link for 20 s', 'unacknowledged']);
});

test('why it stands comes first where the alarm beside it is no more urgent', () => {
  const clock = { ...alarm('a', 3), id: 'c', code: 'clock-wrong', title: 'The clock of a part of it is off', text: '' };
  const { verdict } = of('a', stopped, { alarm: clock });
  assert.deepEqual([verdict.level, verdict.head, verdict.look], [3, stopped.why, 'unacknowledged']);
  assert.equal(verdict.line, 'Reset the stop, then resume. Who: operator. about 1 min. The clock of a part of it is off');
  assert.equal(of('a', stopped, { alarm: { ...clock, escalated: 5 } }).verdict.line, 'Reset the stop, then resume. Who: operator. about 1 min. The clock of a part of it is off. Nobody answered');
  const unsure = of('a', { ...stopped, code: 'weed_unsure', why: 'It cannot tell crop and weed apart here.', clears: 'Look at the row.', takes_s: null }, { alarm: { ...clock, code: 'weed-unsure', escalated: 5 } }).verdict;
  assert.equal(unsure.line, 'Nobody answered. Look at the row. Who: operator');
  const low = of('a', stopped, { alarm: { ...clock, priority: 4 } }).verdict;
  assert.deepEqual([low.level, low.head, low.look, low.group], [3, stopped.why, 'acknowledged', 'needs-you']);
  assert.equal(of('a', { ...stopped, level: 2 }, { alarm: { ...clock, priority: 2, title: 'Crane controller failed' } }).verdict.head, 'Crane controller failed', 'a reset alone mends no fault');
  assert.equal(of('a', { ...stopped, level: 4 }).verdict.level, 3, 'a fault of no weight makes nobody wait less');
});

test('a hold that clears by itself says so beside an alarm, and stands first when the alarm is over', () => {
  const charging = { mode: 'paused', code: 'low_charge', why: 'Paused to charge.', clears: 'Charged, somebody on the farm starts it again.', who: '' };
  const near = { ...alarm('a', 3, 'returned'), id: 'n', code: 'reserve-near', title: 'Battery near the reserve' };
  const over = of('a', charging, { alarm: near }).verdict;
  assert.deepEqual([over.head, over.level, over.look, over.isOver, over.group], ['Paused to charge.', 3, 'returned', true, 'watch']);
  assert.equal(over.line, 'Charged, somebody on the farm starts it again. Battery near the reserve: over. Nobody has acknowledged it.');
  assert.equal(of('a', { mode: 'idle', code: 'charging', why: 'It charges, 100 %.', clears: 'It is ready when charged.' }, { alarm: near }).verdict.head, 'Battery near the reserve: over');
  const float = { mode: 'paused', code: 'rtk_float', why: 'Its position is not exact enough to work.', clears: 'It goes on by itself when RTK is fixed.', who: '' };
  const { verdict } = of('a', float, { alarm: { ...alarm('a', 3), code: 'rtk-float', title: 'Position not exact', text: 'RTK is not fixed.' } });
  assert.deepEqual([verdict.head, verdict.line], ['Position not exact', 'It goes on by itself when RTK is fixed. RTK is not fixed.']);
});

test('what clears it and who can stand before the words of the alarm, and the same is not said twice', () => {
  const robot = { mode: 'auto', waits: true, code: 'person_ahead', why: 'Somebody or something stands in front of it.', clears: 'Clear the way; it goes on by itself after the horn.', who: 'person at the machine' };
  const { verdict } = of('a', robot, { alarm: { ...alarm('a', 2), code: 'person-ahead', title: 'Somebody or something in front of it', text: 'Somebody or something stands in front of the machine.' } });
  assert.equal(verdict.line, 'Clear the way; it goes on by itself after the horn. Who: person at the machine. Somebody or something stands in front of the machine.');
});
