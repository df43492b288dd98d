/** Deleting keytimes, a lock, a flight or a marker, wherever that is asked for. */

import type { Connection } from "./connection";
import { deleteKey, deleteLock } from "./document";
import { findFlight, removeFlight } from "./flights";
import { deleteMarker } from "./markers";
import type { Selection, Store } from "./store";
import { deleteKeys } from "./together";

/** Delete what is selected: all keytimes that are chosen together, or the one thing. */
export function deleteSelected(store: Store, connection: Connection): void {
  const { document, chosenKeys } = store;
  if (chosenKeys.size < 2) return deleteItem(store, connection, store.selection);
  if (document) connection.edit(deleteKeys(document, chosenKeys), "delete keys");
  store.select(null);
}

/** Delete a keytime, a lock, a flight or a marker, and deselect it. The end of the output can't be deleted. */
export function deleteItem(store: Store, connection: Connection, item: Selection): void {
  const { document, selection } = store;
  if (!document || !item) return;
  if (item.kind !== "end" && selection?.kind === item.kind && selection.id === item.id) store.select(null);
  if (item.kind === "key") connection.edit(deleteKey(document, item.id), "delete key");
  if (item.kind === "lock") connection.edit(deleteLock(document, item.id), "delete lock");
  if (item.kind === "marker") connection.edit(deleteMarker(document, item.id), "delete marker");
  const flight = item.kind === "flight" ? findFlight(store.flights, item.id) : null;
  // What was found can't be forgotten, but it can be denied.
  if (flight) connection.edit(removeFlight(document, flight), flight.marked ? "take back flight" : "deny flight");
}
