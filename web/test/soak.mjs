// A day at the page: gestures by the thousand, and what the page holds as it goes; run by tests/fuzz/page_soak.py.
//
//     node soak.mjs '{"python": …, "clip": …, "folder": …, "state": …, "gestures": 3000, "every": 100, "seed": 1}'
//
// Prints a line of JSON for every so many gestures: bytes of the heap after garbage is collected, values of the scripts,
// nodes of documents and listeners. Each round of gestures ends as it began, with one keytime, so what grows is kept by nobody's wish.

import { Editor, launch, serve } from "./editor.mjs";

const { python, clip, folder, state, gestures, every, seed } = JSON.parse(process.argv[2]);
const ROUND = 10;

// Numbers drawn from a seed (a linear congruence), so that a run can be made again.
let drawn = seed;
const draw = () => {
  drawn = (Math.imul(drawn, 1664525) + 1013904223) >>> 0;
  return drawn / 2 ** 32;
};

const browser = await launch();
const command = [python, "-m", "retime.cli.main", "edit", clip, "--no-browser"];
const server = await serve(command, folder, { XDG_STATE_HOME: state });

/**
 * How many objects, functions and lists the scripts hold. What the browser makes of the scripts themselves is not among
 * them: the machine code that it compiles of what runs often takes more and more of the heap for hundreds of gestures.
 */
async function values(cdp) {
  const parts = [];
  const hear = ({ chunk }) => parts.push(chunk);
  cdp.on("HeapProfiler.addHeapSnapshotChunk", hear);
  await cdp.send("HeapProfiler.takeHeapSnapshot", { reportProgress: false });
  cdp.off("HeapProfiler.addHeapSnapshotChunk", hear);
  const { snapshot, nodes } = JSON.parse(parts.join(""));
  const { node_fields: fields, node_types: types } = snapshot.meta;
  const kinds = ["object", "closure", "array"].map((name) => types[0].indexOf(name));
  const kind = fields.indexOf("type");
  let count = 0;
  for (let i = kind; i < nodes.length; i += fields.length) if (kinds.includes(nodes[i])) count++;
  return count;
}

/** What the page holds once nothing waits to be collected. */
async function held(editor, number) {
  const { page } = editor;
  await page.mouse.move(10, 10);
  await editor.settled();
  await editor.frames(3);
  page.cdp ??= await page.context().newCDPSession(page);
  // Twice: what the first leaves to be finalised, the second takes.
  for (let i = 0; i < 2; i++) await page.cdp.send("HeapProfiler.collectGarbage");
  const { nodes, jsEventListeners } = await page.cdp.send("Memory.getDOMCounters");
  const { usedSize } = await page.cdp.send("Runtime.getHeapUsage");
  return { number, bytes: usedSize, nodes, listeners: jsEventListeners, values: await values(page.cdp) };
}

/** Drag a keytime through some places and back, an edit each. */
async function drag(editor, key) {
  const { page } = editor;
  const from = await editor.centre(key);
  const reach = 20 + 40 * draw();
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  // The last is where it began: that it is let go there changes nothing, and has no answer.
  await editor.answered(() => page.mouse.move(from.x + reach, from.y));
  for (let i = 5; i >= 0; i--) await page.mouse.move(from.x + (i / 6) * reach, from.y);
  await page.mouse.up();
}

/** One of what people do; each leaves one keytime. */
async function gesture(editor, number) {
  const { page } = editor;
  const key = editor.keys.nth(0);
  switch (number % ROUND) {
    case 3:
      await page.keyboard.press("Control+z");
      await page.getByRole("button", { name: /^Redo \w/ }).waitFor();
      return page.keyboard.press("Control+Shift+z");
    case 4:
      // Never twice the same: what changes nothing has no answer.
      return editor.setField("Length", `${(85 + 30 * draw()).toFixed(3)}%`);
    case 5: {
      // What is pointed at is explained, and drawn over the stage.
      const box = await editor.canvas.boundingBox();
      for (let i = 1; i < 6; i++) await page.mouse.move(box.x + (i / 6) * box.width, box.y + 0.7 * box.height);
      return;
    }
    case 6:
      await page.keyboard.press("Space");
      await editor.frames(6);
      return page.keyboard.press("Space");
    case 7:
      await page.keyboard.press("?");
      await page.getByRole("dialog", { name: "Keyboard shortcuts" }).waitFor();
      return page.keyboard.press("Escape");
    case 8: {
      // A second keytime comes, and goes by undo.
      await editor.addKey(0.75);
      await page.keyboard.press("Control+z");
      return editor.keys.nth(1).waitFor({ state: "detached" });
    }
    case 9: {
      const name = draw() < 0.5 ? "Overlaid" : "Side by side";
      return page.getByRole("button", { name }).click();
    }
    default:
      return drag(editor, key);
  }
}

try {
  const editor = await Editor.open(browser, server.address, { width: 1280, height: 800 });
  await editor.page.getByRole("button", { name: "Got it" }).click();
  await editor.addKey(0.45);
  await editor.settled();
  for (let number = 0; number <= gestures; number++) {
    if (number % every === 0) console.log(JSON.stringify(await held(editor, number)));
    await gesture(editor, number);
    await editor.frames(1);
  }
  console.log(JSON.stringify({ errors: editor.errors }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
