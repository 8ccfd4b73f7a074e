/** A socket as the page sees it; the test is the network. */
export class FakeSocket extends EventTarget {
  static OPEN = 1;
  /** @type {FakeSocket[]} */
  static all = [];
  readyState = 0;
  bufferedAmount = 0;
  /** @type {any[]} */
  sent = [];

  constructor() {
    super();
    FakeSocket.all.push(this);
  }

  /** @param {string | Uint8Array} message */
  send(message) {
    this.sent.push(message);
  }

  opens() {
    this.readyState = 1;
    this.dispatchEvent(new Event("open"));
  }

  close() {
    this.readyState = 2;
  }

  /** @param {object} message */
  tell(message) {
    this.readyState = 1;
    this.dispatchEvent(new MessageEvent("message", { data: JSON.stringify(message) }));
  }

  gone() {
    this.readyState = 3;
    this.dispatchEvent(new Event("close"));
  }
}
