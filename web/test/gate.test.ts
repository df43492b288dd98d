import { describe, expect, it } from "vitest";
import { Gate } from "../src/gate";

/** A gate whose frames pass, and whose time passes, when the test says so. */
function made(canSend = (): boolean => true) {
  const clock = { now: 1000 };
  const frames: (() => void)[] = [];
  const sent: { value: string; moves: readonly number[] }[] = [];
  const gate = new Gate<string>(
    ({ value, moves }) => {
      if (!canSend()) return false;
      sent.push({ value, moves });
      return true;
    },
    (callback) => frames.push(callback),
    () => clock.now,
  );
  const frame = (): void => {
    clock.now += 16;
    frames.splice(0).forEach((callback) => callback());
  };
  return { gate, sent, frame, frames, clock };
}

describe("changes on their way", () => {
  it("go at once", () => {
    const { gate, sent } = made();
    gate.offer("a", "drag", 1);
    expect(sent).toEqual([{ value: "a", moves: [1] }]);
  });

  it("that follow each other too fast go at the next frame, the newest of a gesture only", () => {
    const { gate, sent, frame, clock } = made();
    gate.offer("a", "drag", 1);
    gate.answered();
    clock.now += 2;
    gate.offer("b", "drag", 2);
    gate.offer("c", "drag", 3);
    expect(sent.map((one) => one.value)).toEqual(["a"]);
    frame();
    expect(sent.at(-1)).toEqual({ value: "c", moves: [2, 3] });
  });

  it("are never two unanswered; the newest goes with the answer", () => {
    const { gate, sent, frame, clock } = made();
    gate.offer("a", "drag", 1);
    gate.offer("b", "drag", 2);
    gate.offer("c", "drag", 3);
    frame();
    expect(sent.map((one) => one.value)).toEqual(["a"]);
    clock.now += 20;
    gate.answered();
    expect(sent.map((one) => one.value)).toEqual(["a", "c"]);
  });

  it("of different gestures are all sent, in order", () => {
    const { gate, sent, frame } = made();
    gate.offer("a", "first", 1);
    gate.offer("b", "second", 2);
    gate.offer("c", "third", 3);
    for (let i = 0; i < 3; i++) {
      gate.answered();
      frame();
    }
    gate.answered();
    expect(sent.map((one) => one.value)).toEqual(["a", "b", "c"]);
    expect(gate.busy).toBe(false);
  });

  it("ask for one frame, however many come", () => {
    const { gate, frames } = made();
    gate.offer("first", "drag", 0);
    gate.answered();
    for (let i = 0; i < 9; i++) gate.offer(String(i), "drag", i);
    expect(frames).toHaveLength(1);
  });

  it("wait where they can't be sent", () => {
    let open = false;
    const { gate, sent, frame } = made(() => open);
    gate.offer("a", "drag", 1);
    frame();
    expect(gate.waits).toBe(true);
    open = true;
    gate.offer("b", "drag", 2);
    frame();
    expect(sent.map((one) => one.value)).toEqual(["b"]);
  });

  it("are dropped where the server refused", () => {
    const { gate, sent, frame } = made();
    gate.offer("a", "drag", 1);
    frame();
    gate.offer("b", "drag", 2);
    gate.reset();
    frame();
    expect(sent.map((one) => one.value)).toEqual(["a"]);
    expect(gate.busy).toBe(false);
  });
});
