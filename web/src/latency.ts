/** How long people wait for a curve, and what a picture costs the page itself; for the measurements. */

/** Tell, once the frame that is being drawn was painted, how long ago these moves of the hand were. */
export function tellLatency(root: HTMLElement, moves: readonly number[]): void {
  if (moves.length === 0) return;
  const channel = new MessageChannel();
  // A message that is sent in a frame arrives after that frame was painted.
  channel.port1.onmessage = () => {
    const now = performance.now();
    root.dispatchEvent(new CustomEvent("retime:curve", { detail: moves.map((moved) => now - moved) }));
  };
  channel.port2.postMessage(null);
}

/** Tell what the page itself worked for a frame, milliseconds: all but what the browser does with it afterwards. */
export function tellFrame(root: HTMLElement, began: number): void {
  root.dispatchEvent(new CustomEvent("retime:frame", { detail: performance.now() - began }));
}
