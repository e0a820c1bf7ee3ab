// The way to the server: one question of a lane in flight, one waiting.

import { decode } from "./frame.js";

const RETRY = [300, 700, 1500, 3000, 5000];

/** Questions over anything that carries texts there and frames back. */
export class Questions {
  /** `post` sends a text; `lanes` maps a lane to what is in flight and what waits. */
  constructor(post) {
    this.post = post;
    this.lastId = 0;
    this.lanes = new Map();
    this.handlers = new Map();
  }

  /** Ask once the lane is free; a question that still waits there is replaced. */
  ask(lane, message, handlers) {
    const at = this.lanes.get(lane) ?? { inFlight: null, waiting: null };
    this.lanes.set(lane, at);
    if (at.inFlight !== null) at.waiting = { message, handlers };
    else this.#send(lane, at, message, handlers);
  }

  /** Ask at once, in place of what the lane was doing. */
  replace(lane, message, handlers) {
    this.lanes.delete(lane);
    this.ask(lane, message, handlers);
  }

  /** Want no more answers of a lane. */
  cancel(lane) {
    this.lanes.delete(lane);
    this.post(JSON.stringify({ id: 0, kind: "cancel", lane }));
  }

  /** Forget what was in flight: the way to the server was lost. */
  forget() {
    this.handlers.clear();
    this.lanes.clear();
  }

  /** Take a frame, and hand it to whoever asked for it. */
  receive(buffer) {
    const { header, arrays } = decode(buffer);
    const found = this.handlers.get(header.id);
    if (found === undefined) return;
    const { lane, handlers } = found;
    const at = this.lanes.get(lane);
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
      this.#send(lane, at, next.message, next.handlers);
    }
  }

  #send(lane, at, message, handlers) {
    const id = (this.lastId += 1);
    at.inFlight = id;
    this.handlers.set(id, { lane, handlers });
    this.post(JSON.stringify({ id, ...message }));
  }
}

/** Open a socket that comes back when it is lost; return the questions over it. */
export function overSocket(address, onState) {
  let socket = null;
  let tries = 0;
  const questions = new Questions((text) => {
    if (socket?.readyState === WebSocket.OPEN) socket.send(text);
  });
  const open = () => {
    socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      tries = 0;
      questions.forget();
      onState(true);
    };
    socket.onmessage = (event) => questions.receive(event.data);
    socket.onclose = () => {
      onState(false);
      setTimeout(open, RETRY[Math.min(tries, RETRY.length - 1)]);
      tries += 1;
    };
  };
  open();
  return questions;
}
