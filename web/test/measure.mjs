// How the editor is to work with: opening, keys made and dragged, playback; run by benchmarks/bench_editor.py.
//
//     node measure.mjs '{"python": …, "clip": …, "folder": …, "state": …, "moves": 60, "seconds": 5, "width": 1920, "height": 1080}'
//
// Prints one JSON object. Seconds of the clock, and beside them those that a processor worked: `cpu` for the server's
// threads, `page` for the page's own thread, which does all but what Chromium draws in processes of its own.

import { readFileSync } from "node:fs";
import { Editor, launch, percentile, serve } from "./editor.mjs";

const { python, clip, folder, state, moves, seconds, width, height } = JSON.parse(process.argv[2]);

const browser = await launch();
// A browser that is warm: what is measured is the editor.
await (await browser.newPage()).goto("about:blank");
const began = performance.now();
const server = await serve([python, "-m", "retime.cli.main", "edit", clip, "--no-browser"], folder, {
  XDG_STATE_HOME: state,
});

/** Seconds of processor time of the server, and its memory, now and at most, in megabytes. Linux tells them. */
function used() {
  const { pid } = server.process;
  // The name of the command stands in brackets, and may have spaces.
  const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  const status = readFileSync(`/proc/${pid}/status`, "utf8");
  const megabytes = (name) => Math.round(Number(new RegExp(`${name}:\\s+(\\d+)`).exec(status)[1]) / 1024);
  return { cpu: (Number(fields[11]) + Number(fields[12])) / 100, now: megabytes("VmRSS"), most: megabytes("VmHWM") };
}

/** Milliseconds that a processor has worked for the page's thread: for all of it, and for its scripts. */
async function worked(page) {
  page.cdp ??= await page.context().newCDPSession(page);
  await page.cdp.send("Performance.enable", { timeDomain: "threadTicks" });
  const { metrics } = await page.cdp.send("Performance.getMetrics");
  const of = (name) => 1000 * metrics.find((one) => one.name === name).value;
  return { all: of("TaskDuration"), scripts: of("ScriptDuration") };
}

const round = (value, places = 2) => Math.round(value * 10 ** places) / 10 ** places;
const found = {};

/** Seconds that something takes, of the clock and of the server's processor. */
async function timed(name, action) {
  const start = performance.now();
  const before = used().cpu;
  await action();
  found[name] = { seconds: round((performance.now() - start) / 1000), cpu: round(used().cpu - before) };
}

/** Let the server come to rest: it explains a curve once nothing else is asked for, of a long take for a second or two. */
async function rested() {
  for (let before = -1, now = used().cpu; now - before > 0.05; ) {
    before = now;
    await new Promise((resolve) => setTimeout(resolve, 1000));
    now = used().cpu;
  }
}

/** Drag a keytime to and fro by some pixels, 30 positions a second; how long each waited for its curve. */
async function drag(editor, key, reach) {
  const { page } = editor;
  const from = await editor.centre(key);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await editor.answered(() => page.mouse.move(from.x + 5, from.y));
  await page.evaluate(() => (window.waited = []));
  const start = performance.now();
  const cpu = used().cpu;
  const pageBefore = await worked(page);
  for (let i = 1; i <= moves; i++) {
    await page.mouse.move(from.x + 5 + reach * Math.sin((i / moves) * Math.PI * 2), from.y);
    const due = start + (1000 * i) / 30;
    await new Promise((resolve) => setTimeout(resolve, Math.max(0, due - performance.now())));
  }
  await page.waitForFunction((n) => window.waited.length >= n, 0.6 * moves, { timeout: 120_000 });
  const told = {
    cpu_ms_a_position: round((1000 * (used().cpu - cpu)) / moves, 1),
    page_ms_a_position: round(((await worked(page)).all - pageBefore.all) / moves, 1),
  };
  await page.mouse.up();
  await editor.settled();
  const waited = await page.evaluate(() => window.waited);
  return {
    positions: waited.length,
    p50: round(percentile(waited, 0.5), 1),
    p95: round(percentile(waited, 0.95), 1),
    most: round(Math.max(...waited), 1),
    ...told,
  };
}

/** Play for some seconds: pictures a second, and what the page itself worked for each. */
async function play(editor) {
  const { page } = editor;
  await rested();
  await page.mouse.move(10, 10);
  await page.keyboard.press("Home");
  await page.keyboard.press("Space");
  await editor.frames(10);
  const before = await worked(page);
  const frames = await page.evaluate(
    (milliseconds) =>
      new Promise((resolve) => {
        const found = [];
        const root = document.querySelector(".retime");
        const hear = (event) => found.push(event.detail);
        root.addEventListener("retime:frame", hear);
        setTimeout(() => {
          root.removeEventListener("retime:frame", hear);
          resolve(found);
        }, milliseconds);
      }),
    1000 * seconds,
  );
  const after = await worked(page);
  await page.keyboard.press("Space");
  return {
    frames_a_second: round(frames.length / seconds, 1),
    work_p50_ms: round(percentile(frames, 0.5)),
    work_p95_ms: round(percentile(frames, 0.95)),
    scripts_cpu_ms_a_frame: round((after.scripts - before.scripts) / frames.length),
    page_cpu_ms_a_frame: round((after.all - before.all) / frames.length),
  };
}

try {
  const editor = await Editor.open(browser, server.address, { width, height });
  const { page } = editor;
  await page.getByRole("button", { name: "Got it" }).click();
  await page.waitForFunction(() => /ms$/.test(document.querySelector(".why dl")?.lastElementChild?.textContent ?? ""));
  found.open = { seconds: round((performance.now() - began) / 1000), cpu: round(used().cpu) };
  await page.evaluate(() => {
    window.waited = [];
    document.querySelector(".retime").addEventListener("retime:curve", (event) => window.waited.push(...event.detail));
  });
  found.play = await play(editor);
  await timed("length 65 %: a new grid", () => editor.setField("Length", "65%"));
  await timed("key made", () => editor.addKey(0.45));
  await editor.settled();
  const key = editor.keys.nth(0);
  found.dragged = await drag(editor, key, 60);
  await timed("length 100 %: another grid", () => editor.setField("Length", "100%"));
  await editor.settled();
  found["dragged across the line of equal speed"] = await drag(editor, key, 60);
  found["dragged there again"] = await drag(editor, key, 60);
  found["play with a keytime"] = await play(editor);
  const { now, most } = used();
  found.memory = { now, most };
  found.errors = editor.errors;
  console.log(JSON.stringify(found));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
