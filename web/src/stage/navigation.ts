/** How the mouse turns the stage: as in the program that the hand knows. */

import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export type Navigation = "retime" | "maya" | "blender";

export const NAVIGATIONS: readonly { readonly name: Navigation; readonly text: string; readonly how: string }[] = [
  { name: "retime", text: "retime", how: "Drag to turn, right button to shift, scroll to come closer" },
  {
    name: "maya",
    text: "Maya",
    how: "Alt + left to turn, Alt + middle to shift, Alt + right or scroll to come closer",
  },
  {
    name: "blender",
    text: "Blender",
    how: "Middle button to turn, Shift + middle to shift, Ctrl + middle or scroll to come closer",
  },
];

const { ROTATE, PAN, DOLLY } = THREE.MOUSE;

/** What a button does; null: nothing. */
export interface Buttons {
  readonly LEFT: THREE.MOUSE | null;
  readonly MIDDLE: THREE.MOUSE | null;
  readonly RIGHT: THREE.MOUSE | null;
}

/** What the buttons do while some keys are held. */
export function buttonsOf(name: Navigation, keys: { readonly altKey: boolean; readonly ctrlKey: boolean }): Buttons {
  if (name === "maya") {
    return keys.altKey ? { LEFT: ROTATE, MIDDLE: PAN, RIGHT: DOLLY } : { LEFT: null, MIDDLE: null, RIGHT: null };
  }
  // With Shift what turns shifts: the controls do that themselves.
  if (name === "blender") return { LEFT: null, MIDDLE: keys.ctrlKey ? DOLLY : ROTATE, RIGHT: null };
  return { LEFT: ROTATE, MIDDLE: DOLLY, RIGHT: PAN };
}

/** Let the buttons do what they do in a program; call it before the controls listen themselves. */
export function navigated(canvas: HTMLElement, controls: () => OrbitControls, now: () => Navigation): void {
  canvas.addEventListener("pointerdown", (event) => {
    controls().mouseButtons = buttonsOf(now(), event);
  });
}
