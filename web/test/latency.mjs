// How long a person who drags a keytime waits for the curve: from each move of the hand to the painted picture.
//
//     node latency.mjs '{"python": …, "clip": …, "options": […], "length": …, "folder": …, "state": …, "moves": 60}'
//
// Prints one JSON object: milliseconds, by the pace of the hand (moves a second).

import { Editor, launch, percentile, serve } from "./editor.mjs";

const { python, clip, options, length, folder, state, moves } = JSON.parse(process.argv[2]);
const browser = await launch();
const server = await serve([python, "-m", "retime.cli.main", "edit", clip, ...options, "--no-browser"], folder, {
  XDG_STATE_HOME: state,
});
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  await editor.setField("Length", length);
  const key = await editor.addKey(0.45);
  await editor.scrub(0.3);
  await page.evaluate(() => {
    window.waited = [];
    document.querySelector(".retime").addEventListener("retime:curve", (event) => window.waited.push(...event.detail));
  });
  const found = {};
  // How often the browser draws at all while nothing happens: what the machine can give.
  const idle = await page.evaluate(async () => {
    const began = performance.now();
    for (let i = 0; i < 60; i++) await new Promise(requestAnimationFrame);
    return Math.round(60_000 / (performance.now() - began));
  });
  for (const pace of [30, 60]) {
    const from = await editor.centre(key);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    // A first step, so that the drag has begun.
    await editor.answered(() => page.mouse.move(from.x + 5, from.y));
    await page.evaluate(() => (window.waited = []));
    const began = performance.now();
    for (let i = 1; i <= moves; i++) {
      await page.mouse.move(from.x + 5 + 60 * Math.sin((i / moves) * Math.PI), from.y + 6 * Math.sin((i / moves) * 9));
      const due = began + (1000 * i) / pace;
      await new Promise((resolve) => setTimeout(resolve, Math.max(0, due - performance.now())));
    }
    const seconds = (performance.now() - began) / 1000;
    // The last move's curve; a browser that is busy takes several moves for one.
    await editor.frames(30);
    await page.mouse.up();
    const waited = await page.evaluate(() => window.waited);
    found[pace] = {
      moves: waited.length,
      moves_a_second: Math.round(moves / seconds),
      p50: Math.round(10 * percentile(waited, 0.5)) / 10,
      p95: Math.round(10 * percentile(waited, 0.95)) / 10,
      most: Math.round(10 * Math.max(...waited)) / 10,
    };
  }
  console.log(
    JSON.stringify({ ...found, idle_frames_a_second: idle, search: await page.locator(".why dd").last().innerText() }),
  );
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
