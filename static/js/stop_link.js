// The ways out of this browser: a raw websocket to the STOP gateway, and plain HTTP to gateway and console.
(() => {
  "use strict";
  const parts = (window.headlandStopParts = window.headlandStopParts || {});
  const FRESH_MS = 1500; // six heartbeats at 4 Hz
  const HALF_OPEN_MS = 3000; // open but silent: another connection is quicker than the old one's time-out
  const BACKOFF_MS = [200, 2000];
  const CONNECT_MS = 2000;
  const REFUSED_MS = 5000;
  const ABORT_MS = 1500;
  const PING_MS = 1000;
  const MOST_PINGS = 8; // waiting for an answer: the oldest tells how late the path is, more add nothing
  const ASLEEP_MS = 2000;

  class GatewaySocket {
    // `on`: {hello, frame(frame), beat(frame), refused(text)}
    constructor(on) {
      this.on = on;
      this.base = "";
      this.token = "";
      this.pause = BACKOFF_MS[0];
      this.lastBeat = -Infinity;
      this.rttMs = null;
      this.refusal = "";
      this.connectAt = Infinity;
      this.pings = new Map(); // not answered yet, oldest first: number -> when it left
    }

    // Point at a gateway; connects at once if something changed.
    use(base, token) {
      if (base === this.base && token === this.token) return;
      [this.base, this.token, this.refusal] = [base, token, ""];
      this.drop();
      this.connectAt = token && base ? 0 : Infinity;
    }

    // Heartbeats say that the gateway reaches this page; only an answered ping says that a press would arrive, and when.
    isFresh(now) {
      const [waiting = now] = this.pings.values();
      return now - this.lastBeat < FRESH_MS && Math.max(now - waiting, this.rttMs) < FRESH_MS;
    }

    // Send now or not at all: HTTP carries the same press, and nothing may arrive from the past.
    send(frame) {
      if (this.socket?.readyState !== WebSocket.OPEN || !this.isWelcome) return false;
      this.socket.send(JSON.stringify(frame));
      return true;
    }

    // A tablet that slept, or whose clock was set: nothing from before counts, the next heartbeat is 250 ms away.
    wasAsleep(now) {
      const apart = Date.now() - now;
      const slept = Math.abs(apart - (this.apart ?? apart)) > ASLEEP_MS;
      this.apart = apart;
      return slept;
    }

    // Called every 100 ms.
    tick(now) {
      if (this.wasAsleep(now)) {
        this.lastBeat = -Infinity;
        this.forget();
      }
      if (!this.socket && now >= this.connectAt) this.connect(now);
      else if (this.socket && !this.isWelcome && now - this.began > CONNECT_MS) this.drop(now);
      else if (this.isWelcome && now - Math.max(this.lastBeat, this.began) > HALF_OPEN_MS) this.drop(now);
      if (this.isWelcome && now - (this.pinged || 0) > PING_MS && this.pings.size < MOST_PINGS) {
        this.pinged = now;
        this.n = (this.n || 0) + 1;
        if (this.send({ k: "ping", n: this.n })) this.pings.set(this.n, now);
      }
    }

    // What was measured on another connection, or before a sleep, says nothing about this one.
    forget() {
      this.pings.clear();
      [this.rttMs, this.pinged] = [null, 0];
    }

    retryNow() {
      if (!this.socket && this.token && this.base) [this.connectAt, this.pause] = [0, BACKOFF_MS[0]];
    }

    connect(now) {
      this.began = now;
      this.isWelcome = false;
      this.forget();
      let socket;
      try {
        socket = this.socket = new WebSocket(`${this.base.replace(/^http/, "ws")}/ws`);
      } catch {
        return this.drop(now);
      }
      socket.onopen = () => socket.send(JSON.stringify({ k: "auth", token: this.token }));
      socket.onmessage = (event) => socket === this.socket && this.read(event.data);
      socket.onclose = socket.onerror = () => socket === this.socket && this.drop(performance.now());
    }

    drop(now = performance.now()) {
      const socket = this.socket;
      [this.socket, this.isWelcome] = [null, false];
      if (socket) {
        socket.onopen = socket.onmessage = socket.onclose = socket.onerror = null;
        socket.close();
      }
      this.connectAt = now + (this.refusal ? REFUSED_MS : this.pause);
      this.pause = Math.min(this.pause * 1.6, BACKOFF_MS[1]);
    }

    read(text) {
      let frame;
      try {
        frame = JSON.parse(text);
      } catch {
        return;
      }
      const now = performance.now();
      if (frame.k === "hb") {
        this.lastBeat = now;
        this.on.beat(frame);
      } else if (frame.k === "hello") {
        [this.isWelcome, this.pause, this.refusal] = [true, BACKOFF_MS[0], ""];
        this.on.hello(frame);
      } else if (frame.k === "pong") {
        if (this.pings.has(frame.n)) this.rttMs = now - this.pings.get(frame.n);
        for (const n of this.pings.keys()) if (n <= frame.n) this.pings.delete(n); // a slow browser hears only the newest
      } else if (frame.k === "refused") {
        this.refusal = String(frame.text || "");
        this.on.refused(this.refusal);
        this.drop(now);
      } else {
        this.on.frame(frame);
      }
    }
  }

  // POST a press; resolves to its steps, or throws. `keepalive` lets it leave although the page is being closed.
  async function post(url, body, headers) {
    const abort = new AbortController();
    const timer = setTimeout(() => abort.abort(), ABORT_MS);
    const options = { method: "POST", body: JSON.stringify(body), headers, keepalive: true, cache: "no-store", signal: abort.signal };
    try {
      const answer = await fetch(url, options);
      if (!answer.ok) throw new Error(String(answer.status));
      return (await answer.json()).steps || [];
    } finally {
      clearTimeout(timer);
    }
  }

  // To the gateway the token goes in a text body: no header, so no preflight that could cost a round trip or fail.
  const toGateway = (base, token, press) =>
    post(`${base}/stop`, { stop_id: press.id, robots: press.robots, token }, { "Content-Type": "text/plain" });

  const toConsole = (base, token, press, csrf) =>
    post(`${base}/api/v1/stop`, { stop_id: press.id, robots: press.robots }, {
      "Content-Type": "application/json",
      ...(token ? { Authorization: `Bearer ${token}` } : {}),
      ...(csrf ? { "X-Headland-CSRF": csrf } : {}),
    });

  Object.assign(parts, { GatewaySocket, toGateway, toConsole });
})();
