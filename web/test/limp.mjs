// A limp in one place, in a real browser: influence painted over time, a limit suggested, an output that leads.
//
//     node limp.mjs '{"python": …, "clip": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: the projects that it saved, for the test to compare with the library's.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, folder, state, shots } = JSON.parse(process.argv[2]);
const browser = await launch();
const server = await serve(
  [python, "-m", "retime.cli.main", "edit", clip, "--project", "limp.retime", "--no-browser"],
  folder,
  { XDG_STATE_HOME: state },
);
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `limp_${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "60%");
  await editor.addKey(0.4);
  await editor.settled();

  // Where the curve spikes a limit is suggested, and one click sets it.
  const limit = page.getByRole("group", { name: "Speed limit suggested" });
  await limit.waitFor();
  await limit.scrollIntoViewIfNeeded();
  await shot("spike");
  await editor.answered(() => limit.getByRole("button").click());
  await until(() => limit.isVisible(), false);
  const speed = await page.getByLabel("Speed limits", { exact: true }).inputValue();
  assert.match(speed, /^\.\.[\d.]+$/);
  await editor.settled();

  // Influence is painted over time: where the hand went the curve is the spline's.
  await page.getByRole("button", { name: "Paint influence over time" }).click();
  await editor.frames(3);
  // The row takes nothing from the map.
  const map = await page.locator(".timeline .overlay[aria-label=Locks]").boundingBox();
  assert.ok(map.height >= 240, `the map is ${map.height} pixels high`);
  const box = await editor.canvas.boundingBox();
  // The row is where the pointer becomes a cross; its lower edge is the spline.
  const left = box.x + 72 + 0.15 * (box.width - 82);
  let y = box.y + box.height - 2;
  const cursor = () => editor.canvas.evaluate((canvas) => canvas.style.cursor);
  await page.mouse.move(left, y);
  while ((await cursor()) !== "crosshair" && y > box.y) await page.mouse.move(left, --y);
  y -= 6;
  const before = await page.getByLabel("Over time", { exact: true }).inputValue();
  assert.equal(before, "");
  await page.mouse.move(left, y);
  await page.mouse.down();
  await editor.answered(() => page.mouse.move(box.x + 72 + 0.35 * (box.width - 82), y + 4, { steps: 6 }));
  await shot("painting");
  await editor.answered(() => page.mouse.up());
  await editor.settled();
  const text = page.getByLabel("Over time", { exact: true });
  await until(async () => /^0s=1, [\d.]+s=1, [\d.]+s=0(\.\d+)?, /.test(await text.inputValue()), true);
  await shot("painted");
  assert.deepEqual(await stumbles(editor), []);
  // One stroke is one step to undo.
  await page.getByRole("button", { name: "Undo paint influence" }).waitFor();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => text.inputValue(), "");
  // Typed, it says the same in words; what is none is refused.
  await text.fill("2s=0, 1s=1");
  await text.press("Enter");
  await page.getByText("expected times that increase").waitFor();
  await text.press("Escape");
  await editor.setField("Over time", "0s=0, 2.5s=0.25, 3s=1");
  await editor.settled();
  await page.keyboard.press("Control+s");
  await page.getByText(/^Saved .*limp\.retime$/).waitFor();
  const painted = { speed, keys: await editor.keys.first().getAttribute("aria-label") };
  await page.getByRole("button", { name: "Dark theme" }).click();
  await editor.frames(3);
  await shot("dark");
  assert.deepEqual(await stumbles(editor), []);
  await page.getByRole("button", { name: "Light theme" }).click();

  // The output as it is now becomes the reference of what comes after.
  const listed = () => page.getByRole("group", { name: "References" }).locator(".pick").allInnerTexts();
  assert.deepEqual(await listed(), ["The clip itself"]);
  const output = page.getByRole("button", { name: "This output as a reference" });
  await output.scrollIntoViewIfNeeded();
  await editor.answered(() => output.click());
  await until(async () => (await listed()).join(), `${clip.replace(/\.bvh$/, "")}_output`);
  await editor.settled();
  await shot("output_as_reference");
  await page.keyboard.press("Control+Shift+s");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(join(folder, "led.retime"));
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(/^Saved .*led\.retime$/).waitFor();
  assert.deepEqual(editor.errors, []);
  console.log(JSON.stringify({ painted: join(folder, "limp.retime"), led: join(folder, "led.retime"), ...painted }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
