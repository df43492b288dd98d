/** What the browser draws the stage with. */

import * as THREE from "three";

/** Whether there is no graphics card, so that the processor draws. */
export function drawsInSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = context && names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/iu.test(String(name));
}

export function makeRenderer(antialias: boolean): THREE.WebGLRenderer | null {
  try {
    return new THREE.WebGLRenderer({ antialias, alpha: true, powerPreference: "low-power" });
  } catch {
    // Without WebGL there is no stage; the timeline works all the same, and the page says so.
    return null;
  }
}
