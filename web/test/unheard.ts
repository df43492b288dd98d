/** What a connection tells, with nobody who hears it. */

export const nothing = (): void => undefined;

export const UNHEARD = {
  notice: nothing,
  listing: nothing,
  found: nothing,
  connected: nothing,
  recovered: nothing,
  resumed: nothing,
  outrun: nothing,
  refused: nothing,
  written: nothing,
  lost: nothing,
  outdated: nothing,
  renewed: nothing,
};
