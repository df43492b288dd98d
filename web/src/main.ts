/** The page in a browser tab: the editor, and a WebSocket to the server that sent it. */

import "./style.css";
import "./page.css";
import { App } from "./app";
import { comeBack } from "./come_back";
import type { Connection, Link } from "./connection";
import { rememberAcrossPorts } from "./memory";

const root = document.getElementById("editor");
if (!root) throw new Error("the page has no place for the editor");

async function upload(file: File): Promise<string> {
  const answer = await fetch(`/drop?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
  if (!answer.ok) throw new Error(await answer.text());
  return ((await answer.json()) as { path: string }).path;
}

rememberAcrossPorts();
const app = new App(root, { upload });
connect(app.connection, 0);

/** Connect, and again where the connection breaks: first soon, then every few seconds. */
function connect(events: Connection, failures: number): void {
  const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  const link: Link = { send: (text) => socket.send(text) };
  let failed = failures;
  socket.addEventListener("open", () => {
    failed = 0;
    events.opened(link);
  });
  socket.addEventListener("message", ({ data }: MessageEvent<string | ArrayBuffer>) => {
    if (typeof data === "string") events.text(data);
    else events.bytes(data);
  });
  socket.addEventListener("close", () => {
    events.closed();
    if (!events.isOutdated) again(events, failed);
  });
}

/** Look for the server again; it may be another run of it, which has to admit the page first. */
function again(events: Connection, failures: number): void {
  const look = async (): Promise<void> => {
    if (await comeBack(events.key)) connect(events, failures + 1);
    else again(events, failures + 1);
  };
  setTimeout(() => void look(), Math.min(400 * 2 ** failures, 5000));
}
