import { describe, expect, it } from "vitest";
import { Connection } from "../src/connection";
import { deleteItem } from "../src/deleting";
import { addKey, addLock } from "../src/document";
import { Store } from "../src/store";
import { EMPTY } from "./empty";
import { nothing, UNHEARD } from "./unheard";

/** A store with a keytime and a lock, and a connection that leads nowhere. */
function made(): { store: Store; connection: Connection; left: () => string[] } {
  const store = new Store(nothing);
  store.setDocument(addLock(addKey(EMPTY, 1, 1)[0], 0, 1)[0]);
  const left = (): string[] => [...(store.document?.keys ?? []), ...(store.document?.locks ?? [])].map((one) => one.id);
  return { store, connection: new Connection(store, UNHEARD, nothing), left };
}

describe("deleting", () => {
  it("takes the one that is meant, which is selected no more", () => {
    const { store, connection, left } = made();
    store.select({ kind: "lock", id: "l1" });
    deleteItem(store, connection, store.selection);
    expect([left(), store.selection]).toEqual([["k1"], null]);
    store.select({ kind: "key", id: "k1" });
    deleteItem(store, connection, { kind: "key", id: "k1" });
    expect([left(), store.selection]).toEqual([[], null]);
  });

  it("leaves another one selected, and the end where it is", () => {
    const { store, connection, left } = made();
    store.select({ kind: "key", id: "k1" });
    deleteItem(store, connection, { kind: "lock", id: "l1" });
    expect([left(), store.selection]).toEqual([["k1"], { kind: "key", id: "k1" }]);
    deleteItem(store, connection, { kind: "end" });
    deleteItem(store, connection, null);
    expect(left()).toEqual(["k1"]);
  });
});
