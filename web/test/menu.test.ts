import { MOUSE } from "three";
import { expect, test } from "vitest";
import { buttonsOf, NAVIGATIONS } from "../src/stage/navigation";

const FREE = { altKey: false, ctrlKey: false };

test("the buttons turn, shift and come closer as in the program that is chosen", () => {
  expect(NAVIGATIONS.map(({ name }) => name)).toEqual(["retime", "maya", "blender"]);
  expect(buttonsOf("retime", FREE)).toEqual({ LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN });
  // Maya: with Alt alone.
  expect(buttonsOf("maya", FREE)).toEqual({ LEFT: null, MIDDLE: null, RIGHT: null });
  expect(buttonsOf("maya", { ...FREE, altKey: true })).toEqual({
    LEFT: MOUSE.ROTATE,
    MIDDLE: MOUSE.PAN,
    RIGHT: MOUSE.DOLLY,
  });
  // Blender: by the middle button; with Shift the controls shift instead of turning.
  expect(buttonsOf("blender", FREE).MIDDLE).toBe(MOUSE.ROTATE);
  expect(buttonsOf("blender", { ...FREE, ctrlKey: true })).toEqual({ LEFT: null, MIDDLE: MOUSE.DOLLY, RIGHT: null });
});
