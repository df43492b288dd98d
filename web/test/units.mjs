// Units, the playhead, values that are dragged, the work area, markers and trimming, in a real browser.
//
//     node units.mjs '{"python": …, "clip": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: the project that it saved.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, folder, state, shots } = JSON.parse(process.argv[2]);
const command = [python, "-m", "retime.cli.main", "edit", clip, "--no-browser"];

const browser = await launch();
const server = await serve(command, folder, { XDG_STATE_HOME: state });
try {
  const editor = await Editor.open(browser, server.address, { dark: true });
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "65%");
  const key = await editor.addKey(0.4);
  await editor.settled();
  const drag = async (locator, dx, dy = 0) => {
    const from = await editor.centre(locator);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    for (let i = 1; i <= 4; i++) await page.mouse.move(from.x + (dx * i) / 4, from.y + (dy * i) / 4);
    await page.mouse.up();
  };

  // The project's rate is told; the switch changes what is shown everywhere, and what is shown can be typed again.
  await page.getByText("60 Hz", { exact: true }).waitFor();
  const units = page.getByLabel("Units of time");
  const outputAt = page.getByLabel("Output at", { exact: true });
  const seconds = Number(await outputAt.inputValue());
  const frame = Math.round(60 * seconds);
  await units.selectOption({ label: "Frames" });
  await until(() => outputAt.inputValue(), `${frame}f`);
  await until(async () => /output \d+f$/.test(await key.getAttribute("aria-label")), true);
  await page.getByText(/^Why, at output \d+f/).waitFor();
  await shot("frames_dark");
  await units.selectOption({ label: "Timecode" });
  const two = (value) => String(value).padStart(2, "0");
  const timecode = (n) => `00:00:${two(Math.floor(n / 60))}:${two(n % 60)}`;
  await until(() => outputAt.inputValue(), timecode(frame));
  await shot("timecode_dark");
  // No field hides the end of a time: its frames.
  const cutOff = () =>
    page
      .locator("input.field:visible, .readout:visible, .playfield:visible")
      .evaluateAll((fields) =>
        fields
          .filter((field) => field.scrollWidth > field.clientWidth + 1)
          .map((field) => `${field.ariaLabel ?? field.textContent}: ${field.value}`),
      );
  const addLock = page.getByRole("button", { name: "Add lock at the playhead" });
  await editor.answered(() => addLock.click());
  for (const does of ["m", "Shift+I"]) await page.keyboard.press(does);
  await page.getByText("One keytime", { exact: true }).click();
  await page.getByLabel("Work area out", { exact: true }).waitFor();
  await until(async () => /^00:/.test(await page.getByLabel("Work area out", { exact: true }).inputValue()), true);
  assert.deepEqual(await cutOff(), []);
  await shot("timecode_lists_dark");
  for (const step of ["set work area", "add marker", "add lock"]) {
    await page.getByRole("button", { name: `Undo ${step} (Ctrl+Z)` }).waitFor();
    await page.keyboard.press("Control+z");
  }
  await page.getByRole("button", { name: "Undo add key (Ctrl+Z)" }).waitFor();
  await page.getByText("One keytime", { exact: true }).click();
  await editor.settled();
  await key.click();
  await until(() => outputAt.inputValue(), timecode(frame));
  await page.mouse.move(640, 120);
  assert.deepEqual(await stumbles(editor), []);
  // Any form of the grammar may be typed, whatever is shown; nothing is changed where the field is left as it was.
  await editor.setField("Output at", `${frame + 30}f`);
  await until(() => outputAt.inputValue(), timecode(frame + 30));
  await editor.setField("Output at", String(frame / 60));
  await until(() => outputAt.inputValue(), timecode(frame));

  // The playhead can be typed, by either of its times.
  const playhead = page.getByLabel("Playhead, output time", { exact: true });
  await playhead.fill("00:00:02:30");
  await playhead.press("Enter");
  await until(() => editor.frame("output"), 150);
  await playhead.fill("0:75");
  await playhead.press("Enter");
  await page.getByText("minutes and seconds after a colon stay below 60").waitFor();
  await page.keyboard.press("Escape");
  await units.selectOption({ label: "Seconds" });
  const shows = page.getByLabel("Playhead, input time shown", { exact: true });
  await shows.fill("5");
  await shows.press("Enter");
  await until(() => shows.inputValue(), "5.00 s");
  await shows.blur();

  // Values can be dragged: a frame for some pixels, one step to undo; a click types.
  const before = Number(await outputAt.inputValue());
  await drag(outputAt, 30);
  await editor.settled();
  await until(async () => Math.round(60 * (await outputAt.inputValue())), frame + 10);
  assert.equal(await outputAt.evaluate((field) => document.activeElement === field), false);
  await page.getByRole("button", { name: "Undo move key" }).waitFor();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => outputAt.inputValue(), before.toFixed(3));
  // A length that was said as a share goes on in frames.
  const length = page.getByLabel("Length", { exact: true });
  const usual = Number(/(\d+) frames/.exec(await page.locator("section[aria-label=Timing]").innerText())[1]);
  await drag(length, 30);
  await until(() => length.inputValue(), `${usual + 10}f`);
  await editor.settled();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => length.inputValue(), "65%");
  await outputAt.click();
  assert.equal(await outputAt.evaluate((field) => document.activeElement === field), true);
  await outputAt.blur();
  const frames = await editor.frame("output");
  await drag(playhead, 15);
  await until(() => editor.frame("output"), frames + 5);

  // Markers: made, named, dragged, snapped to, made keytimes.
  await playhead.fill("120f");
  await playhead.press("Enter");
  await playhead.blur();
  await editor.answered(() => page.keyboard.press("m"));
  const mark = page.getByRole("button", { name: /^Marker.*: output 2\.000 s$/ });
  await mark.waitFor();
  const name = page.getByLabel("Marker's name");
  await name.fill("beat");
  await editor.answered(() => name.press("Enter"));
  await name.blur();
  await page.getByRole("button", { name: "Marker beat: output 2.000 s" }).waitFor();
  await page.keyboard.press("Shift+ArrowRight");
  await editor.answered(() => page.keyboard.press("Shift+M"));
  await until(() => page.locator(".handle.mark").count(), 2);
  await page.keyboard.press("Control+ArrowLeft");
  await until(() => editor.frame("output"), 120);
  // Between two frames it is snapped to all the same: a drag to within some pixels lands on it.
  const time = page.getByLabel("Marker's time").first();
  await editor.answered(async () => {
    await time.fill("2.0123");
    await time.press("Enter");
  });
  await time.blur();
  await key.click();
  const target = await editor.centre(page.getByRole("button", { name: /^Marker beat/ }));
  const at = await editor.centre(key);
  await drag(key, target.x + 3 - at.x);
  await editor.settled();
  await until(async () => /at output 2\.012 s/.test(await key.getAttribute("aria-label")), true);
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(async () => /at output 2\.012 s/.test(await key.getAttribute("aria-label")), false);
  // A keytime that is asked for at the playhead is put there, however near a marker is.
  await playhead.fill("122f");
  await playhead.press("Enter");
  await playhead.blur();
  await editor.answered(() => page.keyboard.press("i"));
  await page.getByRole("button", { name: /^Keytime \d of 2: .* at output 2\.033 s/ }).waitFor();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => editor.keys.count(), 1);
  await page.getByRole("button", { name: "Keytimes from markers" }).scrollIntoViewIfNeeded();
  await shot("markers_dark");
  assert.deepEqual(await stumbles(editor), []);
  await editor.answered(() => page.getByRole("button", { name: "Keytimes from markers" }).click());
  await until(() => editor.keys.count(), 3);
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => editor.keys.count(), 1);

  // The work area: what is played again and again.
  await playhead.fill("60f");
  await playhead.press("Enter");
  await playhead.blur();
  await editor.answered(() => page.keyboard.press("Shift+I"));
  await playhead.fill("75f");
  await playhead.press("Enter");
  await playhead.blur();
  await editor.answered(() => page.keyboard.press("Shift+O"));
  await until(() => page.getByLabel("Work area in", { exact: true }).inputValue(), "1.00");
  await until(() => page.getByLabel("Work area out", { exact: true }).inputValue(), "1.25");
  await shot("workarea_dark");
  await page.keyboard.press("Space");
  const seen = await page.evaluate(
    () =>
      new Promise((resolve) => {
        const readout = document.querySelector(".readout[data-is=output] input");
        const found = [];
        const next = () => {
          found.push(Number.parseFloat(readout.value));
          // Until it has come round twice, however slow the machine is.
          const turns = found.filter((now, i) => i > 0 && now < found[i - 1]).length;
          if (turns >= 2) resolve(found);
          else requestAnimationFrame(next);
        };
        requestAnimationFrame(next);
      }),
  );
  await page.keyboard.press("Space");
  for (const now of seen.slice(1)) assert.ok(now >= 0.995 && now <= 1.255, `${now} lies outside of the work area`);
  const end = page.getByRole("slider", { name: "End of the work area" });
  await end.focus();
  await editor.answered(() => page.keyboard.press("ArrowRight"));
  await until(() => page.getByLabel("Work area out", { exact: true }).inputValue(), (76 / 60).toFixed(2));

  // A clip is trimmed: what was put on its frames stays on them.
  const shownInput = page.getByLabel("Shows input", { exact: true });
  await key.click();
  // The panel shows the keytime that was chosen before until the page has drawn this one.
  const pose = Number(/input ([\d.]+) s/.exec(await key.getAttribute("aria-label"))[1]);
  await until(() => shownInput.inputValue(), pose.toFixed(3));
  await page.locator('section[aria-label="Clips"] summary').first().click();
  await editor.setField("Clip 1: used from", "60f");
  await until(() => shownInput.inputValue(), (pose - 1).toFixed(3));
  await until(() => page.getByLabel("Clip 1: used from", { exact: true }).inputValue(), "1.00");
  const used = page.getByLabel("Clip 1: used to", { exact: true });
  await used.fill("0.5");
  await used.press("Enter");
  await page.getByText("expected a stretch of 4 frames or more, from 0 to").waitFor();
  await page.keyboard.press("Escape");
  await page.keyboard.press("Escape");
  await shot("trimmed_dark");
  // By dragging across its fields, too: a frame a step, never past the other end; and it is one step to undo.
  const usedFrom = page.getByLabel("Clip 1: used from", { exact: true });
  const whole = await used.inputValue();
  await usedFrom.scrollIntoViewIfNeeded();
  await drag(usedFrom, 30);
  await until(() => usedFrom.inputValue(), (70 / 60).toFixed(2));
  await until(() => shownInput.inputValue(), (pose - 70 / 60).toFixed(3));
  await editor.settled();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => usedFrom.inputValue(), "1.00");
  await until(() => shownInput.inputValue(), (pose - 1).toFixed(3));
  await drag(used, -30);
  // The fields show hundredths.
  await until(async () => Math.abs(Number(await used.inputValue()) - (Number(whole) - 10 / 60)) < 0.011, true);
  await editor.settled();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => used.inputValue(), whole);

  // All of it is in the project.
  const project = join(folder, "work.retime");
  await page.keyboard.press("Control+s");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(project);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Saved ${project}`).waitFor();

  assert.deepEqual(editor.errors, []);
  console.log(JSON.stringify({ project, pose }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
