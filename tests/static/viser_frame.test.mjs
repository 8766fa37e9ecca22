// What runs before viser's client in the twin's frame, with a worker that only notes what it is told.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const SOURCE = readFileSync(new URL('../../static/js/viser_frame.js', import.meta.url), 'utf8');

function frame(renderer = 'ANGLE (Intel)') {
  const world = { now: 0, beats: [], told: [], draws: [] };
  class Worker {
    constructor() { this.sent = []; this.listeners = []; }
    addEventListener(_kind, call) { this.listeners.push(call); }
    postMessage(message) { this.sent.push(message); }
    say(type, messages) { this.listeners.forEach((call) => call({ data: { type, messages } })); }
  }
  const canvas = { getContext: () => ({ RENDERER: 7937, getExtension: () => null, getParameter: () => renderer }) };
  const page = {
    Worker, URLSearchParams, location: { pathname: '/viser/', search: '?viewer=abc&robot=weeder-07', protocol: 'http:', host: 'farm:8080', origin: 'http://farm:8080' },
    document: { currentScript: { nonce: '' }, createElement: () => canvas, documentElement: { dataset: {} }, hasFocus: () => false },
    performance: { now: () => world.now }, setInterval: (call) => world.beats.push(call), setTimeout: () => 0,
    requestAnimationFrame: (draw) => world.draws.push(draw), addEventListener() {}, dispatchEvent() {}, ResizeObserver: class { observe() {} }, Event: class {},
    history: { state: null, replaceState: (_state, _title, to) => (world.at = to) },
    parent: { postMessage: (message) => world.told.push(message) }, reportError() {},
  };
  page.window = page;
  vm.runInContext(SOURCE, vm.createContext(page));
  const worker = new page.Worker();
  const pass = (ms) => { for (const end = world.now + ms; world.now < end;) { world.now += 400; world.beats.forEach((beat) => beat()); } };
  const tries = () => worker.sent.filter((one) => one.type === 'retry').length;
  worker.postMessage({ type: 'set_server', server: 'ws://elsewhere' });
  return { page, worker, pass, tries, world, told: world.told };
}

test('the picture comes from our own origin, with the viewer it belongs to', () => {
  const { worker } = frame();
  assert.equal(worker.sent[0].server, 'ws://farm:8080/viser?viewer=abc');
});

test('where the processor draws, the picture is asked for coarser', () => {
  assert.equal(frame().world.at, undefined);
  const { worker, world } = frame('ANGLE (Google, Vulkan (SwiftShader Device))');
  assert.equal(world.at, '/viser/?viewer=abc&robot=weeder-07&fixedDpr=0.6');
  assert.equal(worker.sent[0].server, 'ws://farm:8080/viser?viewer=abc');
});

test('an attempt that is under way is not ended by the next: on a slow link none would ever succeed', () => {
  const { worker, pass, tries } = frame();
  pass(4000);
  worker.postMessage({ type: 'retry' }); // viser's own
  assert.equal(tries(), 0);
  worker.say('connected');
  pass(2000);
  assert.equal(tries(), 0);
});

test('when it was closed it tries at once, and again only when that one ended too', () => {
  const { worker, pass, tries } = frame();
  worker.say('connected');
  worker.say('closed');
  pass(400);
  assert.equal(tries(), 1);
  pass(2000);
  assert.equal(tries(), 1);
  worker.say('closed');
  pass(400);
  assert.equal(tries(), 2);
});

test('an attempt that never ends is given up after six seconds', () => {
  const { pass, tries } = frame();
  pass(8000);
  assert.equal(tries(), 1);
});

test('a request for a public tunnel never leaves', () => {
  const { worker } = frame();
  worker.postMessage({ type: 'send', message: { type: 'ShareUrlRequest' } });
  assert.equal(worker.sent.length, 1);
});

test('the robot is told to be in the picture some rounds after its shapes came, and anew after each connection', () => {
  const { page, worker, pass, world, told } = frame();
  const round = (count) => { for (let i = 0; i < count; i += 1) { page.requestAnimationFrame(() => {}); world.draws.splice(0).forEach((draw) => draw(0)); } };
  const hasModel = () => (pass(400), told.filter((one) => one.kind === 'beat').at(-1).hasModel);
  const ours = [{ type: 'FrameMessage', name: '/machine/weeder-07' }, { type: 'GlbMessage', name: '/machine/weeder-07/arm/skin' }];
  worker.say('connected');
  worker.say('message_batch', [{ type: 'GridMessage', name: '/terrain/grid' }, { type: 'GlbMessage', name: '/machine/weeder-071/skin' }]);
  round(6);
  assert.equal(hasModel(), false);
  worker.say('message_batch', ours);
  assert.equal(hasModel(), false);
  round(5);
  assert.equal(hasModel(), true);
  worker.say('message_batch', [ours[0]]); // a replay stands it elsewhere
  assert.equal(hasModel(), true);
  worker.say('closed');
  worker.say('connected');
  assert.equal(hasModel(), false);
});
