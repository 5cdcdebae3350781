import { said } from "./strings.js";
import { bitmapOf } from "./view/pixels.js";

/** The server's one line about what went wrong, and the field that it is about. */
export class StudioError extends Error {
  constructor(message, { status = 0, parameter = null } = {}) {
    super(said(message));
    this.status = status;
    this.parameter = parameter;
  }
}

/** Calls of the server. The token of this start and the session of this tab go with each. */
export class Api {
  constructor() {
    const parts = location.hash.slice(1).split("&");
    const secret = parts.filter((part) => /^(token|session)=/.test(part));
    for (const [name, value] of secret.map((part) => part.split("="))) sessionStorage.setItem(`weftex-${name}`, value);
    if (secret.length) {
      const rest = parts.filter((part) => !secret.includes(part)).join("&");
      history.replaceState(null, "", rest ? `#${rest}` : location.pathname);
    }
    this.token = sessionStorage.getItem("weftex-token") ?? "";
    this.session = sessionStorage.getItem("weftex-session");
    this.onlost = () => {};
  }

  /** The address that opens a state in another tab: with the token, as the studio printed it. */
  addressOf(hash) {
    return `${location.origin}/#${[`token=${this.token}`, hash.slice(1)].filter(Boolean).join("&")}`;
  }

  async fetch(path, { method = "GET", body, headers = {}, signal, keepalive } = {}) {
    const sent = { "X-Weftex-Token": this.token, ...headers };
    if (this.session) sent["X-Weftex-Session"] = this.session;
    if (body !== undefined && !(body instanceof Blob)) {
      sent["Content-Type"] = "application/json";
      body = JSON.stringify(body);
    }
    let answer;
    try {
      answer = await fetch(`/api/${path}`, { method, body, headers: sent, signal, keepalive });
    } catch (error) {
      if (error.name === "AbortError") throw error;
      this.onlost("gone");
      throw new StudioError("");
    }
    if (answer.ok) return answer;
    const told = await answer.json().catch(() => ({}));
    if (answer.status === 401) this.onlost("token");
    throw new StudioError(told.error ?? `${answer.status} ${answer.statusText}`, { status: answer.status, parameter: told.parameter });
  }

  async get(path, options) {
    return (await this.fetch(path, options)).json();
  }

  async post(path, body = {}, options = {}) {
    return (await this.fetch(path, { method: "POST", body, ...options })).json();
  }

  async remove(path) {
    return this.fetch(path, { method: "DELETE" });
  }

  async begin() {
    const found = await this.post("session", { session: this.session });
    this.session = found.session;
    sessionStorage.setItem("weftex-session", found.session);
    return found;
  }

  /** A picture for the screen, and the whole size that it stands for. */
  async picture(path, options = {}, signal) {
    const query = new URLSearchParams(Object.entries({ ...options, raw: 1 }).filter(([, value]) => value !== undefined && value !== null));
    const answer = await this.fetch(`${path}${path.includes("?") ? "&" : "?"}${query}`, { signal });
    const bitmap = await bitmapOf(await answer.arrayBuffer(), answer.headers.get("X-Weftex-Pixels"));
    const side = (name, other) => Number(answer.headers.get(`X-Weftex-${name}`)) || other;
    return { bitmap, size: [side("Width", bitmap.width), side("Height", bitmap.height)] };
  }

  async upload(file, name = file.name) {
    return this.post("uploads", file, { headers: { "X-Weftex-Name": encodeURIComponent(name), "Content-Type": "application/octet-stream" } });
  }

  /** Queue a job that has one result, and follow it to that. */
  async found(path, body, ontell, signal) {
    const job = await this.post(`${path}?within=250`, body, { signal });
    return (await this.follow(job, ontell, signal)).results[0];
  }

  /**
   * Follow a job to its end; `ontell(job)` hears of every change. Throws the job's error.
   * The wait is cancelled by `signal`; then the job is, too.
   */
  async follow(job, ontell, signal) {
    const cancel = () => this.remove(`jobs/${job.id}`).catch(() => {});
    signal?.addEventListener("abort", cancel, { once: true });
    try {
      while (!ENDED.has(job.state)) {
        ontell(job);
        job = await this.get(`jobs/${job.id}?seen=${job.version}&wait=15`, { signal });
      }
    } finally {
      signal?.removeEventListener("abort", cancel);
    }
    ontell(job);
    if (job.state === "failed") throw new StudioError(job.error, { parameter: job.parameter });
    if (job.state === "cancelled") throw new DOMException("cancelled", "AbortError");
    return job;
  }
}

const ENDED = new Set(["done", "failed", "cancelled"]);
