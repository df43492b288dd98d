import { describe, expect, it } from "vitest";
import { addKey } from "../src/document";
import { Player } from "../src/player";
import { Store } from "../src/store";
import { CURVE, clipOf } from "./clips";
import { EMPTY } from "./empty";

/** A player of 4 s in 2 s, with a keytime at 1.5 s. */
function made(): { store: Store; player: Player; times: () => [number, number] } {
  const store = new Store(() => undefined);
  store.setClip(clipOf({}));
  store.setDocument(addKey(EMPTY, 3, 1.5)[0]);
  store.setCurve(CURVE);
  const times = (): [number, number] => [store.playback.outputTime, store.playback.inputTime];
  return { store, player: new Player(store), times };
}

describe("the player", () => {
  it("plays in true seconds; time in which the page was not drawn does not pass", () => {
    const { player, times } = made();
    player.toggle();
    player.goOn(1000);
    expect(times()).toEqual([0, 0]);
    player.goOn(1100);
    expect(times()[0]).toBeCloseTo(0.1);
    player.goOn(61_100);
    expect(times()[0]).toBeCloseTo(0.35);
    player.toggle();
    player.goOn(61_200);
    expect([player.isPlaying, times()[0].toFixed(2)]).toEqual([false, "0.35"]);
  });

  it("plays from the beginning where it stands at the end", () => {
    const { player, times } = made();
    player.toEdge("end");
    expect(times()[0]).toBe(2);
    player.toggle();
    expect([player.isPlaying, times()[0]]).toEqual([true, 0]);
  });

  it("scrubs in output time by whichever clock, which goes on to lead", () => {
    const { store, player, times } = made();
    player.lead("input");
    player.toggleLink();
    player.scrub(0.5);
    expect([...times(), store.playback.clock]).toEqual([0.5, 1, "input"]);
    player.toEdge("end");
    expect(times()).toEqual([2, 4]);
    player.otherClock();
    expect(store.playback.clock).toBe("output");
  });

  it("goes from keytime to keytime, the ends included, and chooses them", () => {
    const { store, player, times } = made();
    player.toKey(1);
    expect([times()[0], store.selection]).toEqual([1.5, { kind: "key", id: "k1" }]);
    player.toKey(1);
    expect([times()[0], store.selection]).toEqual([2, null]);
    player.toKey(1);
    player.toKey(-1);
    player.toKey(-1);
    expect(times()[0]).toBe(0);
  });

  it("stays inside an output that has become shorter, unless it plays", () => {
    const { store, player, times } = made();
    player.scrub(1.8);
    store.setCurve({ ...CURVE, output_times: Float64Array.of(0, 1) });
    player.stayInside();
    expect(times()[0]).toBe(1);
    player.rewind();
    expect(times()).toEqual([0, 0]);
  });

  it("has nothing to play before there is a curve", () => {
    const store = new Store(() => undefined);
    const player = new Player(store);
    for (const act of [player.toggle, player.stayInside]) act.call(player);
    player.toKey(1);
    player.scrub(1);
    expect([player.isPlaying, store.playback.outputTime]).toEqual([false, 0]);
  });
});
