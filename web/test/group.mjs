// A group in a real browser: lengths that differ, a camera that is looked through, all clips exported at once.
//
//     node group.mjs '{"python": …, "clips": […], "folder": …, "state": …, "shots": …}'
//
// The first clip is a figure, the second a shorter one, the third a camera. Prints one JSON object: what it wrote.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clips, folder, state, shots } = JSON.parse(process.argv[2]);
const browser = await launch();
const server = await serve(
  [python, "-m", "retime.cli.main", "edit", ...clips, "--project", "group.retime", "--no-browser"],
  folder,
  { XDG_STATE_HOME: state },
);
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `group_${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "70%");

  // What ends elsewhere is said beside the clips, and put right by one click.
  const lengths = page.getByRole("group", { name: "Lengths that differ" });
  await lengths.getByText("second ends 1.00 s before first: its last frame is held.").waitFor();
  await lengths.scrollIntoViewIfNeeded();
  await shot("lengths");
  assert.deepEqual(await stumbles(editor), []);
  await editor.answered(() => lengths.getByRole("button", { name: "End second together with first" }).click());
  await until(() => lengths.isVisible(), false);
  await page.getByText("begins at 1s").waitFor();
  await editor.dismiss();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await lengths.waitFor();
  await editor.answered(() => lengths.getByRole("button", { name: "Trim all to 3.00 s" }).click());
  await until(() => lengths.isVisible(), false);
  await editor.settled();
  await editor.dismiss();

  // The camera stands on the stage, and is looked through; both sides through its own moment.
  await page.getByRole("button", { name: "Follow" }).click();
  await editor.scrub(0.15);
  await shot("camera");
  const outside = await editor.stage();
  await page.getByRole("button", { name: "Through camera" }).click();
  await editor.frames(4);
  const early = await editor.stage();
  assert.notEqual(early, outside);
  await shot("through");
  assert.deepEqual(await stumbles(editor), []);
  await editor.scrub(0.8);
  await shot("through_later");
  assert.notEqual(await editor.stage(), early);
  await page.getByRole("button", { name: "Overlaid" }).click();
  await page.getByRole("button", { name: "Dark theme" }).click();
  await editor.frames(4);
  await shot("through_dark");
  await page.getByRole("button", { name: "Through camera" }).click();
  await editor.frames(4);
  await shot("camera_dark");
  await page.getByRole("button", { name: "Side by side" }).click();

  // All clips at once; what is there already is not replaced, and nothing is written then.
  await page.keyboard.press("Control+e");
  const dialog = page.getByRole("dialog", { name: "Export" });
  const path = dialog.getByLabel("Path", { exact: true });
  await dialog.getByLabel("Clip", { exact: true }).selectOption({ label: "All 3 clips" });
  assert.ok((await path.inputValue()).endsWith("*_retimed"));
  await shot("export_all");
  await path.fill(join(folder, "out_*"));
  await dialog.getByRole("button", { name: "Write", exact: true }).click();
  for (const name of clips) await page.getByText(`Wrote ${join(folder, `out_${name}`)}`).waitFor({ timeout: 60_000 });
  await page.keyboard.press("Control+e");
  await dialog.getByLabel("Clip", { exact: true }).selectOption({ label: "All 3 clips" });
  await path.fill(join(folder, "out_*"));
  await dialog.getByRole("button", { name: "Write", exact: true }).click();
  await dialog.getByText(/is there already/).waitFor();
  await path.fill(join(folder, "nothing"));
  await dialog.getByRole("button", { name: "Write", exact: true }).click();
  await dialog.getByText("Write * once").waitFor();
  await dialog.getByRole("button", { name: "Cancel" }).click();

  await page.keyboard.press("Control+s");
  await page.getByText(/^Saved .*group\.retime$/).waitFor();
  assert.deepEqual(editor.errors, []);
  console.log(JSON.stringify({ project: join(folder, "group.retime"), written: clips.map((name) => `out_${name}`) }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
