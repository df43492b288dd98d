import { beforeEach, describe, expect, it } from "vitest";
import { Connection } from "../src/connection";
import { type Document, type State, VERSION } from "../src/messages";
import { Store } from "../src/store";
import { EMPTY } from "./empty";
import { nothing, UNHEARD } from "./unheard";

const key = (output_time: number): Document["keys"][number] => ({ id: "k", input_time: 1, output_time, speed: null });

let sent: { type: string; revision: number; document?: Document }[];
let offered: { label: string; again: () => void }[];
let store: Store;
let connection: Connection;

const state = (
  revision: number,
  document: Document,
  undo: string | null = null,
  redo: string | null = null,
): string => {
  const told: State = {
    type: "state",
    revision,
    document,
    undo_label: undo,
    redo_label: redo,
    saved: true,
    recovered: false,
    resumed: false,
    path: null,
    opened: 0,
  };
  return JSON.stringify(told);
};
const elsewhere = (revision: number): void => connection.text(JSON.stringify({ type: "elsewhere", revision }));

beforeEach(() => {
  sent = [];
  offered = [];
  store = new Store(nothing);
  const events = { ...UNHEARD, outrun: (label: string, again: () => void) => void offered.push({ label, again }) };
  connection = new Connection(store, events, (callback) => callback());
  connection.opened({ send: (text) => void sent.push(JSON.parse(text)) });
  connection.text(state(1, EMPTY));
  sent = [];
});

describe("another window makes a revision", () => {
  it("and what this one sent for the same is offered again, on what holds", () => {
    connection.edit({ ...EMPTY, keys: [key(1)] }, "add key");
    expect(sent.map(({ revision }) => revision)).toEqual([2]);
    elsewhere(2);
    expect(offered).toEqual([]);
    const theirs: Document = { ...EMPTY, method: "spline" };
    connection.text(state(2, theirs));
    expect(store.document).toEqual(theirs);
    expect(offered.map(({ label }) => label)).toEqual(["add key"]);
    offered[0]?.again();
    expect(sent.at(-1)).toMatchObject({ revision: 3, document: { ...theirs, keys: [key(1)] } });
  });

  it("and a drag that goes on is not sent over it", () => {
    for (const [i, done] of [false, false, true].entries()) {
      connection.edit({ ...EMPTY, keys: [key(1 + i)] }, "move key", "drag", done);
      if (i > 0) continue;
      elsewhere(2);
      connection.text(state(2, { ...EMPTY, method: "linear" }));
      // Not in the middle of a drag.
      expect(offered).toEqual([]);
    }
    expect(sent.map(({ revision }) => revision)).toEqual([2]);
    expect(offered.length).toBe(1);
    offered[0]?.again();
    expect(sent.at(-1)).toMatchObject({ revision: 3, document: { method: "linear", keys: [key(3)] } });
  });

  it("and an edit before it is known what they made is offered, not sent", () => {
    elsewhere(2);
    connection.edit({ ...EMPTY, keys: [key(1)] }, "add key");
    expect(sent).toEqual([]);
    connection.text(state(2, { ...EMPTY, method: "linear" }));
    expect(offered.map(({ label }) => label)).toEqual(["add key"]);
    // Who had nothing to lose is offered nothing.
    elsewhere(3);
    connection.text(state(3, EMPTY));
    expect(offered.length).toBe(1);
  });

  it("and what a server had before it died is not offered again", () => {
    const mine = { ...EMPTY, keys: [key(1)] };
    connection.edit(mine, "add key");
    connection.closed();
    connection.opened({ send: (text) => void sent.push(JSON.parse(text)) });
    connection.text(state(1, mine));
    expect(offered).toEqual([]);
    connection.edit({ ...mine, method: "spline" }, "choose method");
    connection.closed();
    connection.opened({ send: (text) => void sent.push(JSON.parse(text)) });
    connection.text(state(1, mine));
    expect(offered.map(({ label }) => label)).toEqual(["choose method"]);
  });
});

describe("undo and redo", () => {
  const types = (): string[] => sent.map(({ type }) => type);

  it("are asked for once what makes their step is answered, however soon they are pressed", () => {
    connection.edit({ ...EMPTY, keys: [key(1)] }, "add key");
    connection.undo();
    connection.redo();
    expect(types()).toEqual(["edit"]);
    connection.text(state(2, { ...EMPTY, keys: [key(1)] }, "add key"));
    expect(types()).toEqual(["edit", "undo"]);
    connection.text(state(3, EMPTY, null, "add key"));
    expect(sent.map(({ type, revision }) => [type, revision])).toEqual([
      ["edit", 2],
      ["undo", 3],
      ["redo", 4],
    ]);
  });

  it("are not asked for where there is no step, and none is on its way", () => {
    connection.undo();
    connection.redo();
    expect(sent).toEqual([]);
    connection.text(state(1, EMPTY, null, "add key"));
    connection.undo();
    expect(sent).toEqual([]);
    connection.redo();
    expect(types()).toEqual(["redo"]);
  });
});

describe("a server of another version", () => {
  let told: string[];
  const welcome = (version: number): string =>
    JSON.stringify({ type: "welcome", version, program: "", opens: [], run: "r", command: "retime edit", key: "k" });

  beforeEach(() => {
    told = [];
    const events = {
      ...UNHEARD,
      connected: () => void told.push("connected"),
      outdated: () => void told.push("outdated"),
      lost: () => void told.push("lost"),
      notice: (_: string, text: string) => void told.push(text),
    };
    connection = new Connection(store, events, (callback) => callback());
    connection.opened({ send: nothing });
  });

  it("is not said to have stopped, when it closes the connection", () => {
    connection.text(welcome(VERSION + 1));
    connection.closed();
    connection.save("a.retime", false);
    expect(told).toEqual(["outdated"]);
    expect(connection.isOutdated).toBe(true);
  });

  it("one of the same version is, and is welcome again", () => {
    connection.text(welcome(VERSION));
    connection.closed();
    expect(told).toEqual(["connected", "lost"]);
    expect(connection.isOutdated).toBe(false);
    connection.save("a.retime", false);
    expect(told.at(-1)).toMatch(/^The server does not answer/);
    connection.opened({ send: nothing });
    connection.text(welcome(VERSION));
    expect(told.at(-1)).toBe("connected");
  });
});
