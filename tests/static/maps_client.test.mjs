// The map's draft over a weak radio: what the server did without its answer coming through is not guessed at.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const zone = (id, radius_m = 5) => ({ type: 'Feature', id, properties: { id, kind: 'obstacle', name: id, radius_m } });
const json = (value) => JSON.parse(JSON.stringify(value));

// a server with one draft, whose answers a test may lose
class Server {
  constructor(...features) {
    this.features = new Map(features.map((one) => [one.id, one]));
    this.log = []; // oldest first
    this.published = null;
    this.asked = [];
    this.loses = () => false; // answers
    this.isDown = false; // requests do not even arrive
  }
  state() {
    const done = this.log.filter((one) => !one.is_undone);
    const undone = this.log.filter((one) => one.is_undone);
    return { base_version: 1, is_mine: true, undo: done.at(-1)?.label ?? null, redo: undone[0]?.label ?? null, undo_id: done.at(-1)?.id ?? null, redo_id: undone[0]?.id ?? null, log: this.log.toReversed().map(({ id, label, is_undone }) => ({ id, label, is_undone })) };
  }
  all() { return { features: [...this.features.values()] }; }
  apply(changes) { for (const { id, after } of changes) after ? this.features.set(id, after) : this.features.delete(id); }
  append(id, label, changes) {
    const known = this.log.find((one) => one.id === id);
    if (known) return { status: 200, draft: this.state(), changes: known.changes };
    if (changes.some((one) => JSON.stringify(this.features.get(one.id) ?? null) !== JSON.stringify(one.before))) return { status: 409, code: 'changed', text: 'The draft is not what was shown here any more.' };
    this.log = [...this.log.filter((one) => !one.is_undone), { id, label, changes, is_undone: false }];
    this.apply(changes);
    return { status: 200, draft: this.state(), changes };
  }
  walk(id, isBack) {
    const next = isBack ? this.log.findLast((one) => !one.is_undone) : this.log.find((one) => one.is_undone);
    const step = id === null || next?.id === id ? next : this.log.find((one) => one.id === id && one.is_undone === isBack);
    if (!step) return { status: 409, code: 'changed', text: 'The draft is not what was shown here any more.' };
    const changes = isBack ? step.changes.toReversed().map(({ id: of, before, after }) => ({ id: of, before: after, after: before })) : step.changes;
    if (step.is_undone !== isBack) this.apply(changes);
    step.is_undone = isBack;
    return { status: 200, draft: this.state(), changes };
  }
  answer(path, body) {
    if (path === '/map') return { status: 200, version: 1, features: { features: [] }, draft: this.published ? null : { ...this.state(), features: this.all() } };
    if (path === '/map/draft/transactions') return this.append(body.id, body.label, body.changes);
    if (path === '/map/draft/undo') return this.walk(body.id ?? null, true);
    if (path === '/map/draft/redo') return this.walk(body.id ?? null, false);
    if (path === '/map/draft/operations') {
      const [id] = body.features;
      const before = this.features.get(id);
      return this.append(body.id, 'Inset', [{ id, before, after: zone(id, before.properties.radius_m + body.args.distance_m) }]);
    }
    if (path === '/map/versions/1/restore') {
      this.append(`back-${String(this.log.length).padStart(4, '0')}`, 'Back to version 1', [...this.features].map(([id, before]) => ({ id, before, after: null })));
      return { status: 200, ...this.state(), features: this.all() };
    }
    if (path === '/map/draft/publish') {
      if (body.last_id && body.last_id !== this.state().undo_id) return { status: 409, code: 'changed', text: 'The draft is not what was shown here any more.' };
      this.published = [...this.features.values()];
      return { status: 200, version: 2 };
    }
    throw new Error(path);
  }
  api(path, body) {
    this.asked.push([path, json(body)]);
    const lost = { ok: false, status: 0, code: 'no_answer', text: 'The server did not answer in time.' };
    if (this.isDown) return lost;
    const answer = json(this.answer(path, json(body)));
    return this.loses(path) ? lost : { ...answer, ok: answer.status < 300, data: answer };
  }
}

// a page over a store that outlives pages; its timers run when a test says so
class Page {
  constructor(server, store) {
    this.timers = [];
    this.nowMs = 5000;
    this.said = [];
    this.refused = [];
    const HL = {
      maps: {}, config: { user: { id: 'anna' } },
      keep: { read: (key, fallback) => (store.has(key) ? json(store.get(key)) : fallback), write: (key, value) => store.set(key, json(value)) },
      port: { api: async (method, path, body) => server.api(path, body ?? null) },
    };
    const later = (run, ms) => this.timers[this.timers.push({ run, ms }) - 1];
    const window = { headland: { uuid: () => `step-${String((Page.ids = (Page.ids ?? 0) + 1)).padStart(4, '0')}` } };
    const context = vm.createContext({ HL, window, performance: { now: () => this.nowMs }, setTimeout: later, clearTimeout: (timer) => (this.timers = this.timers.filter((one) => one !== timer)) });
    Object.assign(HL, { words: {}, maps: { count: String } });
    for (const name of ['maps_queue', 'maps_client', 'maps_chips']) vm.runInContext(fs.readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), context);
    this.maps = HL.maps;
    this.client = new HL.maps.MapClient({ changed() {}, replaced() {}, patched() {}, refused: (labels, why) => this.refused.push(...labels, why), looked: (words) => this.said.push(words) });
  }
  get shown() { return json([...this.client.features.values()]); }
  async settle() {
    for (let i = 0; i < 50; i += 1) await Promise.resolve();
    await this.client.line;
  }
  async passes() {
    const due = this.timers;
    this.timers = [];
    due.forEach((one) => one.run());
    await this.settle();
  }
  async commit(label, id, after) {
    this.client.commit(label, [{ id, before: this.client.features.get(id) ?? null, after }]);
    await this.settle();
  }
}

async function opened(server, store = new Map()) {
  const page = new Page(server, store);
  await page.client.load();
  await page.settle();
  return page;
}

test('a change that the server has, though its answer was lost, is taken back there and not on the screen alone', async () => {
  const server = new Server(zone('well'));
  const page = await opened(server);
  server.loses = (path) => path.endsWith('transactions');
  await page.commit('Well deleted', 'well', null);
  assert.equal(page.client.queue.length, 1);
  server.loses = () => false;
  assert.ok((await page.client.undo()).ok);
  assert.deepEqual(page.shown, [zone('well')]);
  assert.deepEqual([...server.features.keys()], ['well']);
  assert.equal(page.client.redoLabel, 'Well deleted');
  assert.ok((await page.client.publish('', false)).ok);
  assert.deepEqual(server.published, [zone('well')]);
});

test('a change that was tried stays on the screen while it cannot be taken back, after a reload too', async () => {
  const server = new Server(zone('well'));
  const store = new Map();
  const page = await opened(server, store);
  server.loses = () => true;
  await page.commit('Well deleted', 'well', null);
  assert.match((await page.client.undo()).text, /No connection/);
  assert.deepEqual(page.shown, []);
  const kept = store.get('headland.map.queue.anna');
  assert.deepEqual(kept.map((one) => [one.label, one.isTried]), [['Well deleted', true]]);
  assert.deepEqual(Object.keys(server.asked.find(([path]) => path.endsWith('transactions'))[1]), ['id', 'label', 'changes']);
});

test('what was taken back without a link is made again after a reload', async () => {
  const server = new Server(zone('well'));
  const store = new Map();
  const page = await opened(server, store);
  server.isDown = true;
  await page.commit('Pond drawn', 'pond', zone('pond'));
  await page.commit('Tree drawn', 'tree', zone('tree'));
  assert.ok((await page.client.undo()).ok);
  server.isDown = false;
  const again = await opened(server, store);
  assert.deepEqual([...server.features.keys()], ['well', 'pond']);
  assert.equal(again.client.redoLabel, 'Tree drawn');
  again.client.redo();
  await again.settle();
  assert.deepEqual([...server.features.keys()], ['well', 'pond', 'tree']);
  assert.equal(again.client.redoLabel, null);
});

for (const [name, end] of [['another change', (page) => page.commit('Hut drawn', 'hut', zone('hut'))], ['the draft', (page) => page.client.publish('', false)]]) {
  test(`what was taken back is not made again after ${name}`, async () => {
    const server = new Server();
    const store = new Map();
    const page = await opened(server, store);
    server.isDown = true;
    await page.commit('Pond drawn', 'pond', zone('pond'));
    await page.commit('Tree drawn', 'tree', zone('tree'));
    page.client.undo();
    assert.equal(page.client.redoLabel, 'Tree drawn');
    server.isDown = false;
    await end(page);
    assert.equal(page.client.redoLabel, null);
    assert.deepEqual(store.get('headland.map.undone.anna'), []);
  });
}

test('steps taken back here and at the server are made again in their order', async () => {
  const server = new Server();
  const page = await opened(server);
  await page.commit('Pond drawn', 'pond', zone('pond'));
  server.isDown = true;
  await page.commit('Hut drawn', 'hut', zone('hut'));
  await page.commit('Tree drawn', 'tree', zone('tree'));
  page.client.undo();
  server.isDown = false;
  await page.client.undo();
  await page.client.undo();
  assert.deepEqual(page.shown, []);
  for (const label of ['Pond drawn', 'Hut drawn', 'Tree drawn']) {
    assert.equal(page.client.redoLabel, label);
    await page.client.redo();
    await page.settle();
  }
  assert.deepEqual([...server.features.keys()], ['pond', 'hut', 'tree']);
});

for (const [name, ask] of [['undo', (client) => client.undo()], ['an operation', (client) => client.operate('buffer', ['pond'], { distance_m: -1 })]]) {
  test(`after a lost answer to ${name} the map is loaded again before anything else, and nothing is done twice`, async () => {
    const server = new Server();
    const page = await opened(server);
    await page.commit('Tree drawn', 'tree', zone('tree'));
    await page.commit('Pond drawn', 'pond', zone('pond'));
    await page.commit('Pond wider', 'pond', zone('pond', 6));
    server.loses = () => true;
    const answer = await ask(page.client);
    assert.match(answer.text, /may be done or not/);
    assert.ok(page.client.unsure);
    const truth = json([...server.features.values()]);
    assert.match((await page.client.publish('', false)).text, /may be done or not/);
    assert.equal(server.published, null);
    assert.match((await ask(page.client)).text, /may be done or not/);
    server.loses = () => false;
    await page.passes();
    assert.equal(page.client.unsure, null);
    assert.equal(await answer.later, true);
    assert.deepEqual(page.shown, truth);
    assert.deepEqual(json([...server.features.values()]), truth);
    assert.deepEqual(page.said, ['The step whose answer was lost is done.']);
    assert.ok((await page.client.publish('', false)).ok);
    assert.deepEqual(json(server.published), truth);
  });
}

test('pressed again while it is not known, it is looked at and not done again', async () => {
  const server = new Server(zone('pond'));
  const page = await opened(server);
  server.loses = () => true;
  await page.client.operate('buffer', ['pond'], { distance_m: -1 });
  server.loses = () => false;
  assert.match((await page.client.operate('buffer', ['pond'], { distance_m: -1 })).text, /loaded again. Look at it/);
  assert.deepEqual(page.shown, [zone('pond', 4)]);
  assert.deepEqual([...server.features.values()], [zone('pond', 4)]);
});

test('what never arrived is said to be not done', async () => {
  const server = new Server(zone('pond'));
  const page = await opened(server);
  server.isDown = true;
  const answer = await page.client.operate('buffer', ['pond'], { distance_m: -1 });
  await page.passes();
  assert.deepEqual(page.said, []);
  server.isDown = false;
  await page.passes();
  assert.equal(await answer.later, false);
  assert.match(page.said[0], /not done/);
});

test('an undo names its step', async () => {
  const server = new Server();
  const page = await opened(server);
  await page.commit('Pond drawn', 'pond', zone('pond'));
  const [{ id }] = server.log;
  await page.client.undo();
  assert.deepEqual(server.asked.filter(([path]) => path.endsWith('undo')), [['/map/draft/undo', { id }]]);
});

test('a step that this screen never saw is loaded before the next one hides it, and is not published unseen', async () => {
  const server = new Server(zone('pond'));
  const page = await opened(server);
  server.append('late-0001', 'Inset', [{ id: 'pond', before: zone('pond'), after: zone('pond', 4) }]);
  await page.commit('Tree drawn', 'tree', zone('tree'));
  assert.deepEqual(page.shown, [zone('pond', 4), zone('tree')]);
  server.append('late-0002', 'Inset', [{ id: 'pond', before: zone('pond', 4), after: zone('pond', 3) }]);
  assert.equal((await page.client.publish('', false)).code, 'changed');
  assert.equal(server.published, null);
  assert.deepEqual(page.shown, [zone('pond', 3), zone('tree')]);
});

test('what is said of a lost step is true when another page has done a step since', async () => {
  const server = new Server();
  const page = await opened(server);
  await page.commit('Pond drawn', 'pond', zone('pond'));
  const elsewhere = (id) => server.append(id, 'Drawn', [{ id, before: null, after: zone(id) }]);
  server.loses = () => true;
  const operation = await page.client.operate('buffer', ['pond'], { distance_m: -1 });
  elsewhere('hut-0001');
  server.loses = () => false;
  await page.passes();
  assert.equal(await operation.later, true);
  server.isDown = true;
  const undo = await page.client.undo();
  elsewhere('barn-0001');
  server.isDown = false;
  await page.passes();
  assert.equal(await undo.later, false);
  assert.deepEqual(page.shown.map((one) => one.id), ['pond', 'hut-0001', 'barn-0001']);
});

test('a change made while it is not known goes out after the map was loaded, and by itself', async () => {
  const server = new Server(zone('pond'));
  const page = await opened(server);
  server.loses = (path) => path.endsWith('operations') || path === '/map';
  const answer = await page.client.operate('buffer', ['pond'], { distance_m: -1 });
  await page.commit('Tree drawn', 'tree', zone('tree'));
  assert.deepEqual([...server.features.keys()], ['pond']);
  assert.deepEqual(page.shown.map((one) => one.id), ['pond', 'tree']);
  server.loses = () => false;
  await page.passes();
  assert.equal(await answer.later, true);
  assert.deepEqual(page.shown, [zone('pond', 4), zone('tree')]);
  assert.deepEqual([...server.features.values()], page.shown);
  assert.equal(page.client.queue.length, 0);
});

test('a refused look is tried again', async () => {
  const server = new Server(zone('pond'));
  const page = await opened(server);
  server.loses = () => true;
  await page.client.operate('buffer', ['pond'], { distance_m: -1 });
  server.loses = () => false;
  const { answer } = server;
  server.answer = () => ({ status: 403, text: 'Not allowed.' });
  await page.passes();
  assert.ok(page.client.unsure);
  server.answer = answer;
  await page.passes();
  assert.equal(page.client.unsure, null);
  assert.deepEqual(page.timers, []);
});

test('a change whose answer was lost and that another page took back is not shown as done', async () => {
  const server = new Server(zone('well'));
  const page = await opened(server);
  server.loses = (path) => path.endsWith('transactions');
  await page.commit('Well deleted', 'well', null);
  server.loses = () => false;
  server.walk(null, true);
  await page.passes();
  assert.deepEqual(page.shown, [zone('well')]);
  assert.equal(page.client.redoLabel, 'Well deleted');
  const loads = () => server.asked.filter(([path]) => path === '/map').length;
  const before = loads();
  await page.commit('Pond drawn', 'pond', zone('pond'));
  assert.equal(loads(), before); // the usual way loads nothing
});

test('a version is restored when the server has every change of ours', async () => {
  const server = new Server();
  const page = await opened(server);
  server.isDown = true;
  await page.commit('Pond drawn', 'pond', zone('pond'));
  assert.match((await page.client.restore(1)).text, /No connection/);
  server.isDown = false;
  assert.ok((await page.client.restore(1)).ok);
  assert.deepEqual(page.shown, []);
  assert.equal(page.client.queue.length, 0);
  assert.deepEqual(server.log.map((one) => one.label), ['Pond drawn', 'Back to version 1']);
});

test('a version is not restored while a lost answer is open, and what waits for that one hears of it', async () => {
  const server = new Server(zone('pond'));
  const page = await opened(server);
  server.loses = () => true;
  const operation = await page.client.operate('buffer', ['pond'], { distance_m: -1 });
  assert.match((await page.client.restore(1)).text, /may be done or not/);
  server.loses = () => false;
  await page.passes();
  assert.equal(await operation.later, true);
  assert.equal(server.asked.filter(([path]) => path.endsWith('restore')).length, 0);
});

test('a version begins a draft though changes wait since the last one was taken', async () => {
  const server = new Server();
  const page = await opened(server);
  server.isDown = true;
  await page.commit('Pond drawn', 'pond', zone('pond'));
  page.client.draft = { ...page.client.draft, is_mine: false };
  server.isDown = false;
  assert.ok((await page.client.restore(1)).ok);
});

test('whether somebody else holds the draft goes by what the server says is left, not by the clock of the tablet', async () => {
  const server = new Server(zone('well'));
  const state = server.state.bind(server);
  let leftS = 600;
  server.state = () => ({ ...state(), is_mine: false, editor: { name: 'Jonas' }, until_utc: '2001-01-01T06:00:00Z', left_s: leftS });
  const page = await opened(server);
  const isLocked = () => page.maps.isLocked(page.client.draft);
  assert.equal(isLocked(), true, 'though this clock is years past its end');
  page.nowMs += 599_000;
  assert.equal(isLocked(), true);
  page.nowMs += 2_000;
  assert.equal(isLocked(), false);
  leftS = 1800;
  page.client.state(server.state());
  assert.equal(isLocked(), true, 'he goes on');
  assert.equal(page.maps.isLocked(null), false);
});
