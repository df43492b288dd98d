// One continuous piece of work: open, limp, propagate, key, box-move, lock, export, kill, recover; a picture of each step.
//
//     node story.mjs '{"python": …, "clip": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: the project, and the motions exported before and after the server was killed.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, folder, state, shots } = JSON.parse(process.argv[2]);
const start = () =>
  serve([python, "-m", "retime.cli.main", "edit", clip, "--no-browser"], folder, { RETIME_STATE: state });

const browser = await launch();
let server = await start();
try {
  // Open.
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  let step = 0;
  const shot = async (name) => {
    await editor.frames(4);
    await page.screenshot({ path: join(shots, `story_${++step}_${name}.png`) });
  };
  await page.getByRole("button", { name: "Got it" }).click();
  await shot("open");

  // Limp: one stride by hand, its second step slower than the first.
  const limp = [
    [0.16, "2", "2"],
    [0.22, "2.5", "2.4"],
    [0.3, "3.4", "3.9"],
  ];
  for (const [share, input, output] of limp) {
    await editor.addKey(share);
    await editor.setField("Output at", output);
    await editor.setField("Shows input", input);
  }
  await editor.settled();
  await shot("limp");

  // Propagate: the rest of the clip limps too.
  const propagate = page.locator("section[aria-label=Propagate]");
  await propagate.getByText("Input 2.00 to 3.40 s was retimed by hand; the rest follows.").waitFor();
  await editor.answered(() => propagate.getByRole("button", { name: "Propagate", exact: true }).click());
  await propagate.getByText(/^The example speaks for \d+ % of the clip\./).waitFor();
  await shot("propagate");

  // Key: two more, late in the clip, where the limp is too much.
  for (const share of [0.7, 0.8]) await editor.addKey(share);
  await editor.settled();
  await until(() => editor.keys.count(), 5);
  await shot("key");

  // Box-move: both are chosen by a box, and moved together, later.
  const times = async () => {
    const labels = await editor.keys.evaluateAll((keys) => keys.map((key) => key.getAttribute("aria-label")));
    return labels
      .map((label) => /input ([\d.]+) s at output ([\d.]+) s/.exec(label).slice(1).map(Number))
      .sort((a, b) => a[1] - b[1]);
  };
  const before = await times();
  const key = (n) => page.getByRole("button", { name: new RegExp(`^Keytime ${n} of `) });
  const [first, second] = [await editor.centre(key(4)), await editor.centre(key(5))];
  const pull = async (from, to) => {
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    for (let i = 1; i <= 6; i++) {
      await page.mouse.move(from.x + ((to.x - from.x) * i) / 6, from.y + ((to.y - from.y) * i) / 6);
    }
    await page.mouse.up();
  };
  await pull({ x: first.x - 16, y: first.y + 16 }, { x: second.x + 16, y: second.y - 16 });
  await until(() => page.locator('button.handle.key[aria-pressed="true"]').count(), 2);
  await pull(first, { x: first.x + 22, y: first.y });
  await editor.settled();
  const after = await times();
  const by = after[3][1] - before[3][1];
  assert.ok(by > 0.05, `moved by ${by} s`);
  assert.ok(Math.abs(after[4][1] - before[4][1] - by) < 0.0021);
  assert.deepEqual(after.slice(0, 3), before.slice(0, 3));
  await shot("box_move");

  // Lock: a span that plays at its own speed.
  const box = await editor.canvas.boundingBox();
  await page.mouse.move(box.x + 40, box.y + 110);
  await page.mouse.down();
  await editor.answered(() => page.mouse.move(box.x + 40, box.y + 94, { steps: 3 }));
  await page.mouse.up();
  await page.locator(".handle.band").first().waitFor();
  await editor.settled();
  assert.equal(await page.locator(".trouble").isVisible(), false);
  await shot("lock");

  // Export, of what was saved.
  const dialog = page.getByRole("dialog");
  const write = async (keys, file) => {
    await page.keyboard.press(keys);
    await dialog.getByLabel("Path", { exact: true }).fill(join(folder, file));
    await page.getByRole("button", { name: "Write", exact: true }).click();
    await dialog.waitFor({ state: "hidden", timeout: 60_000 });
    return join(folder, file);
  };
  const project = await write("Control+s", "limp.retime");
  await page.keyboard.press("Control+e");
  await shot("export");
  await page.keyboard.press("Escape");
  const exported = await write("Control+e", "limp.bvh");

  // Kill, after one more change that nobody saved.
  const length = await page.getByLabel("Length", { exact: true }).inputValue();
  await editor.setField("Length", "16");
  await page.locator(".project").getByText("edited", { exact: true }).waitFor();
  await editor.settled();
  const shown = await editor.readout("input");
  server.process.kill("SIGKILL");
  await server.ended;
  await page.locator(".veil code").waitFor();
  await shot("killed");

  // Recover: the same command; the same tab goes on, with the change, and undo back to before it.
  server = await start();
  await page.locator(".veil").waitFor({ state: "hidden", timeout: 30_000 });
  await page.getByText("Everything that was done is back").waitFor();
  await until(() => page.getByLabel("Length", { exact: true }).inputValue(), "16");
  await until(() => editor.readout("input"), shown);
  await shot("recovered");
  const longer = await write("Control+e", "longer.bvh");
  await editor.dismiss();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => page.getByLabel("Length", { exact: true }).inputValue(), length);
  await page.keyboard.press("Control+s");
  await page.locator(".project").getByText("saved", { exact: true }).waitFor();
  const again = await write("Control+e", "again.bvh");
  const light = await stumbles(editor);
  await page.getByRole("button", { name: "Dark theme" }).click();
  await shot("dark");
  assert.deepEqual([...light, ...(await stumbles(editor))], []);
  // A killed server is missed by the browser too; of nothing else it complains.
  assert.deepEqual(
    editor.errors.filter((error) => !/ERR_CONNECTION_(REFUSED|RESET)|WebSocket connection/.test(error)),
    [],
  );
  console.log(JSON.stringify({ project, exported, longer, again, keys: after, pictures: step }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
