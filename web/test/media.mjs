// A video or a sound beside the stage, beats, and a film of the stage, in a real browser.
//
//     node media.mjs '{"python": …, "clip": …, "media": …, "beats": …, "picture": …, "extras": …, "folder": …, "state": …, "shots": …}'
//
// `media` is a file of 4 s whose sound clicks, `picture` says whether it has one, with its number coded in each frame;
// `beats` is a table of times. Prints one JSON object: what it found, for the test to compare.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, media, beats, picture, extras, folder, state, shots } = JSON.parse(process.argv[2]);
const named = ["--media", media, "--media-offset", "-6f", "--beats", beats, "--project", "work.retime"];
const command = [python, "-m", "retime.cli.main", "edit", clip, ...named, "--no-browser"];

const browser = await launch();
const server = await serve(command, folder, { XDG_STATE_HOME: state });
const found = {};
try {
  let editor = await Editor.open(browser, server.address);
  let { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `media_${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "60%");

  // The player is where the warp says, offset and all, at every place of the playhead.
  const player = page.locator(".media video");
  const section = page.getByRole("region", { name: "Video and sound" });
  await until(() => player.evaluate((video) => video.readyState > 0), true);
  const shown = () => player.evaluate((video) => (video.seeking ? null : Math.round(1000 * video.currentTime) / 1000));
  const input = async () => Number.parseFloat(await editor.readout("input"));
  const length = await player.evaluate((video) => video.duration);
  found.places = [];
  for (const share of [0.1, 0.35, 0.6]) {
    await editor.scrub(share);
    // The readout has two decimals; the player a thousandth more than the moment, for what browsers round.
    const wanted = Math.min((await input()) + 6 / 60, length);
    await until(async () => Math.abs(((await shown()) ?? -1) - wanted) < 0.007, true);
    found.places.push(await shown());
  }
  if (picture) {
    // The very frame of the video that belongs to the moment: its number is in its picture.
    await until(() => page.locator(".media").isVisible(), true);
    found.frames = [];
    for (const share of [0.2, 0.45]) {
      await editor.scrub(share);
      const wanted = (await input()) + 6 / 60;
      await until(async () => Math.abs(((await shown()) ?? -1) - wanted) < 0.007, true);
      await editor.frames(3);
      found.frames.push([await player.evaluate(numberIn), await shown()]);
    }
  } else assert.equal(await page.locator(".media").isVisible(), false);
  // Its waveform is on the timeline, and the beats' ticks.
  await section.getByText("5 beats found").waitFor();
  await section.scrollIntoViewIfNeeded();
  await shot("light");
  assert.deepEqual(await stumbles(editor), []);

  // A keytime that is dragged near a beat of the output lands on it; with Alt it does not.
  const key = await editor.addKey(0.5);
  const at = async () => Number(/output ([\d.]+) s$/.exec(await key.getAttribute("aria-label"))[1]);
  const box = await editor.canvas.boundingBox();
  const ruler = async (share) => {
    await editor.scrub(share);
    return Number.parseFloat(await editor.readout("output"));
  };
  const [early, late] = [await ruler(0.2), await ruler(0.6)];
  const xOf = (time) => box.x + 72 + (box.width - 82) * (0.2 + (0.4 * (time - early)) / (late - early));
  const drag = async (time, modifier) => {
    const from = await editor.centre(key);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    if (modifier) await page.keyboard.down(modifier);
    await editor.answered(() => page.mouse.move(xOf(time), from.y, { steps: 4 }));
    await editor.answered(() => page.mouse.up());
    if (modifier) await page.keyboard.up(modifier);
    await editor.settled();
  };
  const beat = 1.303;
  const pixel = (late - early) / (0.4 * (box.width - 82));
  await drag(beat + 4 * pixel);
  await until(at, beat);
  await drag(beat - 5 * pixel, "Alt");
  assert.notEqual(await at(), beat);
  // Switched off, it lands on frames.
  await section.getByLabel("Keytimes snap to beats").uncheck();
  await drag(beat + 4 * pixel);
  assert.notEqual(await at(), beat);
  assert.ok(Math.abs((await at()) * 60 - Math.round((await at()) * 60)) < 0.04);
  await section.getByLabel("Keytimes snap to beats").check();
  await page.keyboard.press("Delete");
  await until(() => editor.keys.count(), 0);
  await editor.settled();

  // It plays at the speed of the warp, and stands still with the playhead.
  await page.keyboard.press("Home");
  await page.getByRole("button", { name: /^Play \(/ }).click();
  await until(() => player.evaluate((video) => !video.paused && video.currentTime > 0.3), true);
  found.speed = await player.evaluate((video) => video.playbackRate);
  await page.keyboard.press("Space");
  await until(() => player.evaluate((video) => video.paused), true);
  const stood = Math.min((await input()) + 6 / 60, length);
  await until(async () => Math.abs(((await shown()) ?? -1) - stood) < 0.007, true);

  // A song keeps the output's time.
  await section.getByLabel("Goes with").selectOption("output");
  await editor.setField("Begins at", "0.25");
  await editor.scrub(0.4);
  const song = Number.parseFloat(await editor.readout("output")) - 0.25;
  await until(async () => Math.abs(((await shown()) ?? -1) - song) < 0.007, true);
  // What is no time is said beside the field.
  const offset = section.getByLabel("Begins at");
  await offset.fill("soon");
  await offset.press("Enter");
  await section.getByText(/expected a time such as/).waitFor();
  await offset.press("Escape");

  // Beats of the sound itself: found, or it is said which extra is missing.
  await section.getByLabel("Beats", { exact: true }).selectOption("onsets");
  const heard = section.getByText(extras ? /^(?!5 )\d+ beats? found$/ : /pip install 'retime\[(beats|video)\]'/);
  await heard.waitFor({ timeout: 60_000 });
  found.heard = await heard.innerText();
  await section.scrollIntoViewIfNeeded();
  await shot("beats");

  // Dark, and finely drawn.
  await page.getByRole("button", { name: "Dark theme" }).click();
  await editor.frames(4);
  await shot("dark");
  assert.deepEqual(await stumbles(editor), []);
  await page.getByRole("button", { name: "Light theme" }).click();

  // A film of the stage, every frame once, with the sound as it is heard through the warp; without the extra it is said
  // before anything is drawn.
  await section.getByLabel("Goes with").selectOption("input");
  await editor.settled();
  const film = join(folder, "stage.webm");
  await page.keyboard.press("Control+e");
  const dialog = page.getByRole("dialog", { name: "Export" });
  await dialog.getByLabel("What", { exact: true }).selectOption({ label: "Film of the stage (MP4, WebM, GIF)" });
  await dialog.getByLabel("Size", { exact: true }).selectOption("640x360");
  await dialog.getByLabel("Rate", { exact: true }).fill("12");
  assert.match(await dialog.getByLabel("Path", { exact: true }).inputValue(), /_stage\.mp4$/);
  await dialog.getByLabel("Path", { exact: true }).fill(film);
  // Its sound is offered by name.
  assert.equal(await dialog.getByLabel(`Sound of ${media}`).isChecked(), true);
  await shot("export");
  await dialog.getByRole("button", { name: "Write", exact: true }).click();
  const filming = page.getByRole("dialog", { name: "Film of the stage" });
  if (extras) {
    await filming.getByText(/^Frame \d+ of \d+$/).waitFor();
    await shot("filming");
    await filming.getByText(`Wrote ${film}`).waitFor({ timeout: 120_000 });
    found.film = film;
    found.seconds = await page.evaluate(() =>
      Number(document.querySelector(".readout[data-is=output] input").value.slice(0, -2)),
    );
  } else await filming.getByText(/pip install 'retime\[video\]'/).waitFor();
  await filming.getByRole("button", { name: "Close" }).click();

  // All of it is saved, and there again; what is beside the stage can be taken away, and brought back.
  await page.keyboard.press("Control+s");
  await page.getByText(/^Saved .*work\.retime$/).waitFor();
  found.project = join(folder, "work.retime");
  await section.getByRole("button", { name: "Take it away" }).click();
  await until(() => section.getByLabel("Goes with").isVisible(), false);
  await until(() => player.evaluate((video) => video.readyState), 0);
  // So is a sound that is dropped on the page put beside it: half a second of nothing.
  await page.evaluate(() => {
    const data = new DataView(new ArrayBuffer(44 + 8000));
    const say = (at, text) => [...text].forEach((letter, i) => data.setUint8(at + i, letter.charCodeAt(0)));
    for (const [at, text] of [
      [0, "RIFF"],
      [8, "WAVEfmt "],
      [36, "data"],
    ])
      say(at, text);
    for (const [at, number] of [
      [4, 36 + 8000],
      [16, 16],
      [24, 8000],
      [28, 16_000],
      [40, 8000],
    ])
      data.setUint32(at, number, true);
    for (const [at, number] of [
      [20, 1],
      [22, 1],
      [32, 2],
      [34, 16],
    ])
      data.setUint16(at, number, true);
    const transfer = new DataTransfer();
    transfer.items.add(new File([data.buffer], "dropped.wav"));
    document
      .querySelector(".retime")
      .dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
  });
  await section.getByRole("button", { name: "dropped.wav" }).waitFor();
  await until(() => player.evaluate((video) => Math.round(100 * video.duration)), 50);
  await page.keyboard.press("Control+z");
  await until(() => player.evaluate((video) => video.readyState), 0);
  await page.keyboard.press("Control+z");
  await until(() => player.evaluate((video) => video.readyState > 0), true);
  // What is refused the browser notes too.
  const wrong = editor.errors.filter((error) => !error.startsWith("Failed to load resource"));
  assert.deepEqual(extras ? editor.errors : wrong, []);
  await page.close();

  // Another file is refused by what it holds, and by where it lies; the page says so and goes on.
  editor = await Editor.open(browser, server.address, { scale: 2, dark: true });
  ({ page } = editor);
  for (const [path, says] of [
    ["list.mp4", /playlist/],
    ["nothing.wav", /can't play nothing\.wav/],
  ]) {
    const aside = page.getByRole("region", { name: "Video and sound" });
    await aside.getByRole("button", { name: /\.(wav|webm|mp4)$/ }).click();
    await page.getByRole("dialog").getByRole("button", { name: path }).click();
    await aside.getByText(says).first().waitFor();
    await aside.scrollIntoViewIfNeeded();
    await page.screenshot({ path: join(shots, `media_refused_${path}.png`) });
  }
  console.log(JSON.stringify(found));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}

/** The number that a test's clip has in each of its pictures: ten blocks in the upper quarter. */
function numberIn(video) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
  const pen = canvas.getContext("2d");
  pen.drawImage(video, 0, 0);
  const block = Math.floor(canvas.width / 10);
  let number = 0;
  for (let bit = 0; bit < 10; bit++) {
    const [red] = pen.getImageData(bit * block + Math.floor(block / 2), Math.floor(canvas.height / 8), 1, 1).data;
    if (red > 128) number |= 1 << bit;
  }
  return number;
}
