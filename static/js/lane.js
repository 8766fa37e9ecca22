// The live lane in the browser: one websocket, one clock, one state, shared by everything on the page.
// Protocol: docs/protocols/lane.md. Plain script without imports; offers window.headland.
(function (global) {
  'use strict';

  const LATE_S = 1.0, STALE_S = 2.0, LOST_S = 3.5;      // streams of 2 Hz and more
  const LATE_PERIODS = 1.5, STALE_PERIODS = 3.0;        // slower streams
  const FAST_PERIOD_MS = 500;
  const TICK_STALE_S = 1.0;                             // ten ticks missed: the picture is old
  const TICK_LOST_S = 3.5;
  const TICK_USABLE_S = 2.0;                            // the console refuses older ticks, so none is offered
  const CHECK_MS = 100, HERE_MS = 1000, PING_MS = 1000;
  const BACKOFF_MS = [200, 400, 800, 1500, 2500];       // a console restart takes about 2 s
  const OPEN_LIMIT_MS = 4000;                           // a handshake that hangs longer is given up
  const COMMAND_LIMIT_MS = 3000;
  const OFFSET_WINDOW = 600;                            // one minute of ticks: follows clock drift
  const AT_MOST_M_JUMP_MS = 5000;
  const LISTS = { fleet: 'robots', alarms: 'alarms' };  // topics whose deltas carry only entries that changed

  const config = global.HEADLAND || {};
  const listeners = new Map();   // topic -> Set of fn(state, topic, changed)
  const state = new Map();       // topic -> object of groups
  const arrived = [];            // per tick: performance.now() - m, newest last
  let numbers = [];              // robot ids by their number in binary frames
  let socket = null, attempt = 0, retryAt = 0, openedAt = 0, isEnded = false;
  let boot = null, revision = -1, hello = null;
  let offset = null;             // smallest (performance.now() - m) of the window
  let tickId = null, tickM = null, tickAt = -Infinity;
  let asked = [], wanted = '[]';  // what sub() was told, and what the console was told
  const pings = new Map(), legs = []; // when each was sent; half the round trips of the last minute
  let pingNumber = 0, rtt = null, leg = 0;
  let control = null;
  let linkState = 'server-lost', linkSince = performance.now();
  let reconnects = 0;

  // ---- time ---------------------------------------------------------------------------------------------

  // The fastest frame of the window was under way too: half of the shortest round trip.
  function now() { return offset === null ? null : performance.now() - offset + leg; }

  function learn(m) {
    const seen = performance.now() - m;
    if (offset !== null && seen < offset - AT_MOST_M_JUMP_MS) arrived.length = 0; // this machine slept
    arrived.push(seen);
    if (arrived.length > OFFSET_WINDOW) arrived.shift();
    // The smallest delay of the window: a frame can be late, never early.
    if (offset === null || seen <= offset) offset = seen;
    else if (arrived.length % 10 === 0 || arrived.length < 10) offset = Math.min.apply(null, arrived);
  }

  function age(t) {
    const n = now();
    return t === null || t === undefined || n === null ? null : Math.max(0, (n - t) / 1000);
  }

  function freshness(t, periodMs) {
    const a = age(t);
    if (a === null) return 'missing';
    const p = periodMs || FAST_PERIOD_MS;
    if (p <= FAST_PERIOD_MS) {
      return a >= LOST_S ? 'lost' : a >= STALE_S ? 'stale' : a >= LATE_S ? 'late' : 'fresh';
    }
    return a >= STALE_PERIODS * p / 1000 ? 'stale' : a >= LATE_PERIODS * p / 1000 ? 'late' : 'fresh';
  }

  function ageText(seconds) {
    if (seconds === null || seconds === undefined || Number.isNaN(seconds)) return '––';
    const s = Math.max(0, seconds);
    if (s < 9.95) return s.toFixed(1) + ' s';
    if (s < 59.5) return s.toFixed(0) + ' s';
    const whole = Math.round(s);
    if (whole < 3600) return Math.floor(whole / 60) + ':' + String(whole % 60).padStart(2, '0');
    const minutes = Math.round(s / 60);
    return Math.floor(minutes / 60) + ' h ' + String(minutes % 60).padStart(2, '0');
  }

  function tickAge() { return (performance.now() - tickAt) / 1000; }

  function tick() {
    // An id that came in a held burst is as old as its time says, not as its arrival.
    if (tickId === null || !isOpen()) return null;
    return Math.max(tickAge(), age(tickM)) < TICK_USABLE_S ? tickId : null;
  }

  // ---- state --------------------------------------------------------------------------------------------

  function on(topic, fn) {
    if (!listeners.has(topic)) listeners.set(topic, new Set());
    listeners.get(topic).add(fn);
    subscribe();
    if (state.has(topic)) call(fn, state.get(topic), topic, null);
    return function off() { listeners.get(topic).delete(fn); subscribe(); };
  }

  function call(fn, value, topic, changed) {
    try { fn(value, topic, changed); } catch (error) { console.error('headland: a listener of ' + topic + ' failed', error); }
  }

  function tell(topic, value, changed) {
    const all = listeners.get(topic);
    if (all) for (const fn of Array.from(all)) call(fn, value, topic, changed);
  }

  function merge(topic, groups) {
    const held = state.get(topic) || {};
    const list = LISTS[topic];
    const next = Object.assign({}, held, groups);
    if (list) {
      // The fleet's entries are brought up to date in place: copying a thousand of them each time is dear.
      const entries = next[list] = topic === 'fleet' && held[list] ? held[list] : Object.assign({}, held[list]);
      for (const [id, entry] of Object.entries(groups[list] || {})) {
        if (entry === null) delete entries[id]; else entries[id] = topic === 'fleet' ? take(id, entry, entries[id]) : entry;
      }
    }
    state.set(topic, next);
    tell(topic, next, Object.keys(list ? groups[list] || {} : groups));
  }

  // An entry says what changes slowly, of a known robot only what changed; when it was heard comes in beats and is kept.
  function take(id, entry, before) {
    if (typeof entry.n === 'number') numbers[entry.n] = id;
    return Object.assign({ t: null, rtt_ms: null }, before, entry);
  }

  function snapshot(data) {
    for (const [topic, groups] of Object.entries(data)) {
      if (topic === 'poses') {
        for (const [id, n] of Object.entries(groups.numbers)) numbers[n] = id;
        const robots = {};
        for (const [id, p] of Object.entries(groups.places || {})) robots[id] = { lat: p[0], lon: p[1], heading_deg: p[2], t: p[3] };
        state.set('poses', { robots });
        tell('poses', state.get('poses'), null);
        continue;
      }
      if (topic === 'fleet') {
        for (const [id, entry] of Object.entries(groups.robots)) {
          const beat = (groups.beats || {})[id] || [null, null];
          groups.robots[id] = take(id, entry, { t: beat[0], rtt_ms: beat[1] });
        }
        state.set('fleet', { robots: groups.robots });
        tell('fleet', state.get('fleet'), null);
        continue;
      }
      state.set(topic, groups);
      tell(topic, groups, null);
    }
  }

  function binary(buffer) {
    if (buffer.byteLength < 20) return;
    const view = new DataView(buffer);
    const rev = view.getUint32(4, true);
    if (rev <= revision) return;
    revision = rev;
    const kind = view.getUint32(0, true), m = view.getFloat64(8, true), count = view.getUint32(16, true);
    if (kind === 0x31504c48) poses(view, m, count);       // "HLP1"
    else if (kind === 0x31424c48) beats(view, m, count);  // "HLB1"
  }

  // Entries are brought up to date in place: a list redraws when it wants to, nobody is called a thousand times.
  function beats(view, m, count) {
    const robots = (state.get('fleet') || { robots: {} }).robots;
    for (let i = 0, at = 20; i < count; i++, at += 8) {
      const entry = robots[numbers[view.getUint32(at, true)]];
      if (entry === undefined) continue;
      const age = view.getUint16(at + 4, true), rttMs = view.getUint16(at + 6, true);
      entry.t = age === 65535 ? null : m - age * 10;
      entry.rtt_ms = rttMs === 65535 ? null : rttMs;
    }
    tell('fleet', state.get('fleet') || { robots: {} }, []);
  }

  function poses(view, m, count) {
    const held = state.get('poses') || { robots: {} };
    const changed = [];
    for (let i = 0, at = 20; i < count; i++, at += 16) {
      const id = numbers[view.getUint32(at, true)];
      if (id === undefined) continue;
      const place = held.robots[id] || (held.robots[id] = { lat: 0, lon: 0, heading_deg: 0, t: 0 });
      place.lat = view.getInt32(at + 4, true) / 1e7;
      place.lon = view.getInt32(at + 8, true) / 1e7;
      place.heading_deg = view.getUint16(at + 12, true) / 100;
      place.t = m - view.getUint16(at + 14, true) * 10;
      changed.push(id);
    }
    state.set('poses', held);
    tell('poses', held, changed);
  }

  // ---- frames -------------------------------------------------------------------------------------------

  function receive(message) {
    if (typeof message.data !== 'string') { binary(message.data); return; }
    let frame;
    try { frame = JSON.parse(message.data); } catch (error) { return; }
    switch (frame.k) {
      case 'hello': greet(frame); break;
      case 'tick':
        learn(frame.m);
        if (tickM === null || frame.m > tickM) {
          tickId = frame.id; tickM = frame.m; tickAt = performance.now();
          state.set('tick', { stop: frame.stop, keeper: frame.keeper || [] });
        }
        tell('tick', state.get('tick'), null);
        check();
        break;
      case 'snap':
        if (frame.rev >= revision) { revision = frame.rev; snapshot(frame.d); }
        break;
      case 'delta':
        if (frame.rev > revision) {
          revision = frame.rev;
          for (const [topic, groups] of Object.entries(frame.d)) merge(topic, groups);
        }
        break;
      case 'event': tell('event', frame.d, null); break;
      case 'pong': {
        const sent = pings.get(frame.n);
        if (sent === undefined) break;
        rtt = performance.now() - sent;
        pings.clear();
        legs.push(rtt / 2);
        if (legs.length > 60) legs.shift();
        leg = Math.min.apply(null, legs);
        break;
      }
      case 'bye':
        isEnded = frame.code !== 'full';
        tell('bye', frame, null);
        if (isEnded) dispatch('headland:bye', frame);
        break;
    }
  }

  function greet(frame) {
    if (boot !== null && boot !== frame.boot) reconnects += 1;
    boot = frame.boot; hello = frame; revision = -1; attempt = 0; numbers = [];
    // Another run of the console has another clock: nothing of the old one maps.
    offset = null; arrived.length = 0; tickId = null; tickM = null; tickAt = -Infinity;
    if (typeof frame.m === 'number') learn(frame.m);
    wanted = '[]';
    subscribe();
    ping();
    tell('hello', frame, null);
  }

  function isOpen() { return socket !== null && socket.readyState === 1; }

  function transmit(frame) {
    if (!isOpen()) return false;              // dropped, never queued: nothing may act late
    if (socket.bufferedAmount > 65536) return false;
    socket.send(JSON.stringify(frame));
    return true;
  }

  function send(frame) { return linkState !== 'server-lost' && transmit(frame); }

  function sub(topics) {
    asked = Array.from(new Set(topics));
    subscribe();
  }

  // Robots are asked for by name; the lists come as long as anybody listens to them.
  function subscribe() {
    const lists = ['fleet', 'poses', 'alarms'].filter(function (topic) { return listeners.has(topic) && listeners.get(topic).size > 0; });
    const topics = Array.from(new Set(asked.concat(lists)));
    for (const topic of Array.from(state.keys())) if (topic !== 'tick' && !topics.includes(topic)) state.delete(topic);
    const text = JSON.stringify(topics);
    if (text !== wanted && transmit({ k: 'sub', topics })) wanted = text;
  }

  function ping() {
    const n = ++pingNumber;
    if (pings.size > 20) pings.clear();
    pings.set(n, performance.now());
    transmit(tickM === null ? { k: 'ping', n } : { k: 'ping', n, m: tickM });
  }

  // ---- connection ---------------------------------------------------------------------------------------

  function url() {
    const path = config.lanePath || '/live';
    if (/^wss?:/.test(path)) return path;
    return (location.protocol === 'https:' ? 'wss://' : 'ws://') + location.host + path;
  }

  function connect() {
    openedAt = performance.now();
    let mine;
    try { mine = new WebSocket(url()); } catch (error) { retryAt = performance.now() + 2500; return; }
    socket = mine;
    mine.binaryType = 'arraybuffer';
    mine.onmessage = function (message) { if (socket === mine) receive(message); };
    mine.onclose = function (event) { if (socket === mine) closed(event.code); };
    mine.onerror = function () { /* onclose follows */ };
  }

  function closed(code) {
    socket = null;
    rtt = null;
    pings.clear();
    legs.length = 0; // the next connection may take another way
    if (code === 4401 && !isEnded) { isEnded = true; dispatch('headland:bye', { code: 'signed_out', text: '' }); }
    if (!isEnded) {
      const wait = BACKOFF_MS[Math.min(attempt, BACKOFF_MS.length - 1)];
      attempt += 1;
      retryAt = performance.now() + wait * (0.75 + Math.random() * 0.5); // tablets of a farm do not knock at once
    }
    check();
  }

  function drop() {
    const old = socket;
    if (old === null) return;
    old.onclose = old.onmessage = null;
    try { old.close(); } catch (error) { /* it was never open */ }
    closed(1006);
  }

  function look() {
    const t = performance.now();
    if (isOpen() && t - tickAt < 1.5 * CHECK_MS) return; // looked at with its newest tick
    if (socket === null) {
      if (!isEnded && t >= retryAt) connect();
    } else if (!isOpen()) {
      if (t - openedAt > OPEN_LIMIT_MS) drop();
    } else if (tickAge() > 2 * TICK_LOST_S && t - openedAt > 2 * TICK_LOST_S * 1000) {
      drop(); // a socket that says nothing is dead, whatever the browser believes
    }
    check();
  }

  function judge() {
    if (isEnded || tickId === null) return 'server-lost';
    const a = Math.max(tickAge(), age(tickM) || 0);
    if (a >= TICK_LOST_S) return 'server-lost';
    return a >= TICK_STALE_S || !isOpen() ? 'stale' : 'ok';
  }

  function check() {
    const found = judge();
    if (found === linkState) return;
    linkState = found;
    linkSince = performance.now();
    dispatch('headland:link', { state: found, since: linkSince });
    tell('link', found, null);
  }

  function dispatch(name, detail) {
    if (global.dispatchEvent) global.dispatchEvent(new CustomEvent(name, { detail }));
  }

  // ---- orders -------------------------------------------------------------------------------------------

  function uuid() {
    // crypto.randomUUID is missing on plain http in a local network
    const b = crypto.getRandomValues(new Uint8Array(16));
    return Array.from(b, function (x) { return x.toString(16).padStart(2, '0'); }).join('');
  }

  function problem(code, text) { return { ok: false, status: 0, code, text }; }

  async function api(method, path, body, limitMs) {
    const headers = { Accept: 'application/json' };
    if (method !== 'GET') headers['X-Headland-CSRF'] = config.csrf || '';
    if (body !== undefined && body !== null) headers['Content-Type'] = 'application/json';
    const abort = new AbortController();
    const timer = setTimeout(function () { abort.abort(); }, limitMs || 10000);
    try {
      const response = await fetch((config.apiPath || '/api/v1') + path, {
        method, headers, signal: abort.signal, credentials: 'same-origin', cache: 'no-store',
        body: body === undefined || body === null ? undefined : JSON.stringify(body),
      });
      let data = null;
      try { data = await response.json(); } catch (error) {
        // an answer that was cut off is none: taken for an empty one it would say that there is nothing
        if (response.ok && response.status !== 204) throw error;
      }
      const answer = Object.assign({}, data && typeof data === 'object' && !Array.isArray(data) ? data : {},
        { ok: response.ok, status: response.status, data });
      if (!response.ok && !answer.text) answer.text = 'The server answered ' + response.status + '.';
      return answer;
    } catch (error) {
      return abort.signal.aborted ? problem('no_answer', 'The server did not answer in time.')
        : problem('no_connection', 'The server cannot be reached.');
    } finally {
      clearTimeout(timer);
    }
  }

  async function command(robot, action, params) {
    const fresh = tick();
    if (linkState === 'server-lost' || fresh === null) {
      return Object.assign(problem('server_lost', 'Not sent: the link to the server is lost.'), { outcome: 'rejected' });
    }
    const body = Object.assign({ command_id: uuid(), action, tick: fresh }, params || {});
    const answer = await api('POST', '/robots/' + encodeURIComponent(robot) + '/commands', body, COMMAND_LIMIT_MS);
    if (!answer.outcome) {
      // Nothing came back: it may have taken effect. A refusal by the server did not.
      answer.outcome = answer.status >= 400 && answer.status < 500 ? 'rejected' : 'unknown';
    }
    answer.command_id = body.command_id;
    return answer;
  }

  function here() {
    const fresh = control === null ? null : tick();
    if (fresh !== null && linkState !== 'server-lost') transmit({ k: 'here', robot: control, tick: fresh });
  }

  function setControl(robot) {
    if (control === robot) return;
    control = robot || null;
    here();
  }

  // ---- NiceGUI ------------------------------------------------------------------------------------------
  // socket.io keeps what is emitted while it is disconnected and sends it on reconnect: a press would act
  // seconds later. Presses ("event") made then are dropped; everything else of NiceGUI passes.

  function guard(io) {
    if (!io || io.headlandGuard || typeof io.emit !== 'function') return;
    const emit = io.emit;
    io.headlandGuard = true;
    io.emit = function (name) {
      if (name === 'event' && !io.connected) {
        dispatch('headland:dropped', { name });
        return io;
      }
      return emit.apply(io, arguments);
    };
    if (typeof io.on === 'function') {
      io.on('disconnect', function () {
        if (Array.isArray(io.sendBuffer)) {
          io.sendBuffer = io.sendBuffer.filter(function (packet) { return !(packet.data && packet.data[0] === 'event'); });
        }
      });
    }
  }

  global.headland = {
    on, sub, send, tick, now, age, freshness, ageText, api, command, setControl, uuid,
    state: function (topic) { return state.get(topic); },
    control: function () { return control; },
    hello: function () { return hello; },
    revision: function () { return revision; },
    rtt: function () { return rtt; },
    link: function () { return linkState; },
    linkFor: function () { return (performance.now() - linkSince) / 1000; },
    tickAge,
    attempt: function () { return attempt; },
    reconnects: function () { return reconnects; },
    config,
  };

  setInterval(function () { guard(global.socket); look(); }, CHECK_MS);
  setInterval(here, HERE_MS);
  setInterval(function () { if (isOpen()) ping(); }, PING_MS);
  if (global.addEventListener) {
    global.addEventListener('online', function () { retryAt = 0; look(); });
    global.addEventListener('pageshow', function () { retryAt = 0; look(); });
  }
  connect();
})(window);
