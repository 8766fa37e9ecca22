// Leaves half of a slow device to the rest of the page: after a picture that took long, the next one waits as long.

const FREE_MS = 50; // a picture within three screen refreshes costs nobody anything
const MOST_MS = 500;
const UNSEEN = 4; // pictures after a quick one that are not measured: measuring asks for a frame of its own

export class FramePace {
  #askedAt = null;
  #notBefore = 0;
  #unseen = 0;

  /** A picture was asked for. */
  asked() {
    this.#askedAt ??= performance.now();
  }

  /** The picture was drawn: it is on screen when the browser asks for the next frame. */
  drawn() {
    const asked = this.#askedAt;
    if (asked === null) return;
    this.#askedAt = null;
    if (this.#unseen > 0) return void (this.#unseen -= 1);
    requestAnimationFrame((now) => {
      const cost = now - asked;
      this.#notBefore = cost > FREE_MS ? now + Math.min(cost, MOST_MS) : 0;
      this.#unseen = cost > FREE_MS ? 0 : UNSEEN;
    });
    return undefined;
  }

  waitMs() {
    return Math.max(0, this.#notBefore - performance.now());
  }
}
