// Requests to the server: in each queue one is in flight and one waits.

import { decode } from "./frame.js";

// The longest message that the server takes.
const LONGEST = 1e6;
const RETRY = [300, 700, 1500, 3000, 5000];

/** Sends requests as texts, and hands the frames of their answers to whoever sent them. */
export class Requests {
  /** `post` sends a text, `end` ends the connection; `queues` maps a name to the request in flight and the one that waits. */
  constructor(post, end = () => {}) {
    this.post = post;
    this.end = end;
    this.lastId = 0;
    this.queues = new Map();
    this.handlers = new Map();
  }

  /** Send a request once its queue is free; one that still waits there is replaced. */
  put(queue, message, handlers) {
    const at = this.queues.get(queue) ?? { inFlight: null, waiting: null };
    this.queues.set(queue, at);
    if (at.inFlight !== null) at.waiting = { message, handlers };
    else this.#send(queue, at, message, handlers);
  }

  /** Send a request at once, in place of the one in flight. */
  replace(queue, message, handlers) {
    this.queues.delete(queue);
    this.put(queue, message, handlers);
  }

  /** Cancel the requests of a queue. */
  cancel(queue) {
    this.queues.delete(queue);
    this.post(JSON.stringify({ id: 0, kind: "cancel", queue }));
  }

  /** Forget what was in flight: the connection was lost. */
  forget() {
    this.handlers.clear();
    this.queues.clear();
  }

  /** Nothing is sent or heard any more. */
  close() {
    this.forget();
    this.end();
  }

  /** Hand a frame to the handlers of its request. */
  receive(buffer) {
    const { header, arrays } = decode(buffer);
    const entry = this.handlers.get(header.id);
    if (entry === undefined) return;
    const { queue, handlers } = entry;
    const at = this.queues.get(queue);
    const isCurrent = at?.inFlight === header.id;
    if (header.kind === "progress") {
      if (isCurrent) handlers.progress?.(header.share);
      return;
    }
    const isLast = header.kind === "fault" || header.done !== false;
    if (isLast) this.handlers.delete(header.id);
    if (!isCurrent) return;
    if (header.kind === "fault") handlers.fault?.(header.faults);
    else handlers.answer(header, arrays);
    if (!isLast) return;
    at.inFlight = null;
    if (at.waiting !== null) {
      const next = at.waiting;
      at.waiting = null;
      this.#send(queue, at, next.message, next.handlers);
    }
  }

  #send(queue, at, message, handlers) {
    const id = (this.lastId += 1);
    const text = JSON.stringify({ id, ...message });
    if (text.length > LONGEST) {
      handlers.fault?.([{ path: "", reason: "more than 1 MB, the most on the page; percuss run takes any" }]);
      return;
    }
    at.inFlight = id;
    this.handlers.set(id, { queue, handlers });
    this.post(text);
  }
}

/** Open a socket that reconnects when it is lost; return the requests over it. */
export function overSocket(address, onState) {
  let socket = null;
  let tries = 0;
  let waiting = null;
  const post = (text) => {
    if (socket?.readyState === WebSocket.OPEN) socket.send(text);
  };
  const end = () => {
    clearTimeout(waiting);
    socket.onopen = socket.onclose = null;
    socket.close();
  };
  const requests = new Requests(post, end);
  const open = () => {
    socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      tries = 0;
      requests.forget();
      onState(true);
    };
    socket.onmessage = (event) => requests.receive(event.data);
    socket.onclose = () => {
      onState(false);
      waiting = setTimeout(open, RETRY[Math.min(tries, RETRY.length - 1)]);
      tries += 1;
    };
  };
  open();
  return requests;
}
