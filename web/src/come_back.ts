/** To a server that was started anew at the same address: proofs on both sides, see retime.server.returning. */

/** Have the server admit this page; false where it is another's, or does not answer. `key` is what the page was told. */
export async function comeBack(key: string): Promise<boolean> {
  if (key === "") return true;
  try {
    const word = hex(crypto.getRandomValues(new Uint8Array(24)));
    const greeted = await fetch(`/resume?word=${word}`, { cache: "no-store" });
    if (!greeted.ok) return false;
    const theirs = (await greeted.json()) as { readonly proof: string; readonly word: string };
    // Whoever has taken the port, and is not this editor, is told nothing.
    if (theirs.proof !== (await proof(key, "server", word))) return false;
    const own = await proof(key, "page", theirs.word);
    const answer = await fetch(`/resume?word=${encodeURIComponent(theirs.word)}&proof=${own}`, { method: "POST" });
    return answer.ok;
  } catch {
    // Nobody listens yet.
    return false;
  }
}

async function proof(key: string, who: "server" | "page", word: string): Promise<string> {
  const encode = (text: string): Uint8Array<ArrayBuffer> => new TextEncoder().encode(text);
  const hmac = { name: "HMAC", hash: "SHA-256" };
  const imported = await crypto.subtle.importKey("raw", encode(key), hmac, false, ["sign"]);
  return hex(new Uint8Array(await crypto.subtle.sign("HMAC", imported, encode(`${who} ${location.host} ${word}`))));
}

function hex(bytes: Uint8Array): string {
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
