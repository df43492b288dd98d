/** What the browser remembers of a person's choices: theme, view, hints seen. */

let acrossPorts = false;

/**
 * Remember in cookies from now on. `retime edit` takes another port each time, and a browser's storage belongs to one
 * port; its cookies belong to the machine.
 */
export function rememberAcrossPorts(): void {
  acrossPorts = true;
}

export function recall(name: string): string | null {
  try {
    if (!acrossPorts) return localStorage.getItem(name);
    const found = document.cookie.split("; ").find((cookie) => cookie.startsWith(`${name}=`));
    return found === undefined ? null : decodeURIComponent(found.slice(name.length + 1));
  } catch {
    // A browser that may keep nothing, or a cookie that another program wrote.
    return null;
  }
}

export function remember(name: string, value: string): void {
  try {
    if (acrossPorts) {
      // biome-ignore lint/suspicious/noDocumentCookie: the store that could write it otherwise is not in every browser.
      document.cookie = `${name}=${encodeURIComponent(value)}; path=/; max-age=31536000; samesite=strict`;
    } else localStorage.setItem(name, value);
  } catch {
    // A browser that keeps nothing forgets the choice, no more.
  }
}

/** What this tab was told before it was loaded again. */
export function recallInTab(name: string): string | null {
  try {
    return sessionStorage.getItem(name) ?? inThisPage.get(name) ?? null;
  } catch {
    return inThisPage.get(name) ?? null;
  }
}

export function rememberInTab(name: string, value: string): void {
  inThisPage.set(name, value);
  try {
    sessionStorage.setItem(name, value);
  } catch {
    // A browser that may keep nothing tells it again after the page was loaded again.
  }
}

const inThisPage = new Map<string, string>();
