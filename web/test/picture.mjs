// Takes the picture of the editor for the docs; run by tools/take_editor_picture.py.

import { Editor, launch, serve } from "./editor.mjs";

const { python, clip, folder, state, picture } = JSON.parse(process.argv[2]);
const browser = await launch();
const server = await serve([python, "-m", "retime.cli.main", "edit", clip, "--no-browser"], folder, {
  XDG_STATE_HOME: state,
});
try {
  const editor = await Editor.open(browser, server.address, { width: 1280, height: 760, scale: 1.25 });
  const { page } = editor;
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "65%");
  const key = await editor.addKey(0.62);
  const from = await editor.centre(key);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await editor.answered(() => page.mouse.move(from.x + 24, from.y, { steps: 4 }));
  await page.mouse.up();
  await page.getByRole("button", { name: "Onion skins" }).click();
  await editor.scrub(0.405);
  await key.focus();
  await page.waitForTimeout(1500);
  await page.screenshot({ path: picture });
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
