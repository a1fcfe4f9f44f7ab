// Follows a run while it computes: fetches its states and rows, and sends commands.

import { LivePanel } from "./live-panel.js";

/** Number of attempts to reach a run that no longer answers. */
const ATTEMPTS = 5;
/** Time after which a refused page tries again [ms]. */
const PAUSE = 2000;

export class Live {
  /** `show` creates the view of the case when its first state has arrived. */
  constructor(body, settings, show) {
    Object.assign(this, { body, settings, show, app: null, news: null, failures: 0, gone: new Set(), rows: 0, follows: true, commands: [] });
    this.iterations = [];
    this.panel = new LivePanel(settings, (command) => this.command(command));
    this.#listen();
  }

  #listen() {
    this.source = new EventSource("events");
    this.source.onmessage = (event) => this.#hear(JSON.parse(event.data));
    this.source.onerror = () => this.#fail();
  }

  #hear(news) {
    if (news.run !== this.settings.run) return this.#over();
    this.failures = 0;
    this.news = news;
    const last = this.iterations.at(-1)?.[0] ?? -1;
    this.iterations.push(...news.iterations.filter(([k]) => k > last));
    this.iterations.splice(0, this.iterations.length - 60);
    this.panel.update(news, this.iterations);
    this.#fetch();
  }

  /** Handles that another run is now shown at this address. */
  #over() {
    this.source.close();
    this.panel.end("This run has ended. The states that have come stay; load the page again to see the run that goes on now.");
  }

  /** Handles a lost connection. The browser reconnects by itself unless it was refused; a run that has ended no longer answers. */
  #fail() {
    if (!this.news?.ended && this.source.readyState === EventSource.CLOSED) return this.#again();
    this.failures += 1;
    if (this.news?.ended || this.failures >= ATTEMPTS) this.#close();
    else this.#say("The run does not answer; trying again …");
  }

  /** Shows why the run refuses to be followed, e.g. because too many pages are open, and tries again. */
  async #again() {
    const look = new AbortController();
    const words = await fetch("events", { signal: look.signal }).then((answer) => (answer.ok ? "" : answer.text()), () => "");
    look.abort();
    this.#say(`The run cannot be followed now${words && `: ${words.trim()}`}. Trying again …`);
    setTimeout(() => this.#listen(), PAUSE);
  }

  /** Shows a message about the run, also while no state is shown yet. */
  #say(text) {
    this.panel.say(text);
    const opening = document.getElementById("state");
    if (!this.app && opening) opening.textContent = text;
  }

  #close() {
    this.source.close();
    if (!this.news?.ended) this.panel.end("The run does not answer any more. The states that have come stay.");
  }

  /** Numbers of the states still to be fetched, the newest first. */
  #missing() {
    const { stride, count } = this.news.states;
    const missing = [];
    if (count > 0) for (let k = 0; k < count - 1; k += stride) if (!this.body.kept.has(k) && !this.gone.has(k)) missing.push(k);
    if (count > 0 && !this.body.kept.has(count - 1) && !this.gone.has(count - 1)) missing.unshift(count - 1);
    return missing;
  }

  /** Fetches one item after the other, at the pace of this page. */
  async #fetch() {
    if (this.busy) return;
    this.busy = true;
    try {
      for (;;) {
        const { rows, states } = this.news;
        const [next] = this.#missing();
        if (rows.count > this.rows) {
          // The response may be newer than the message that triggered the request, and itself says which rows exist
          const { rows: own, ...extent } = await (await fetch(`rows?from=${this.rows}`)).json();
          this.body.takeRows(own, extent);
          this.rows = extent.count;
        } else if (next !== undefined) {
          const answer = await fetch(`states/${next}`);
          if (answer.ok) this.body.take(next, this.body.read(await answer.arrayBuffer()), states);
          else this.gone.add(next);
        } else break;
        this.#grow();
      }
      if (this.news.ended) this.source.close();
    } catch {
      // The event stream tells whether the run still answers
    }
    this.busy = false;
  }

  #grow() {
    if (!this.body.states) return;
    if (!this.app) {
      this.app = this.show();
      this.panel.place(this.app.panel);
      const seek = this.app.seek.bind(this.app);
      // The newest state is shown unless the user has selected an earlier one
      this.app.seek = (t) => {
        seek(t);
        this.follows = Math.round(this.body.stateAt(this.app.s.time)) === this.body.states - 1;
      };
    }
    const { follows } = this;
    this.app.grow();
    if (follows && !this.app.out.running) this.app.seek(this.app.times[1]);
  }

  /** Sends a command; of several values of a signal in quick succession only the last one. */
  command(command) {
    const { signal } = command.set ?? {};
    this.commands = this.commands.filter((c) => !signal || c.set?.signal !== signal);
    this.commands.push(command);
    if (!this.sends) this.#send();
  }

  async #send() {
    this.sends = true;
    for (let next; (next = this.commands.shift()); ) {
      const body = JSON.stringify(next.set ? next : next.name);
      try {
        const answer = await fetch("command", { method: "POST", headers: { "Content-Type": "application/json" }, body });
        if (!answer.ok) this.panel.say((await answer.text()).trim());
      } catch {
        this.panel.say("The run does not answer.");
      }
    }
    this.sends = false;
  }
}
