/** How loud a sound is, at every scale: computed once, drawn at any zoom. */

export interface Peaks {
  /** Seconds of each of the finest parts. */
  readonly step: number;
  /** The greatest amplitude of each part; of each level the parts are `FACTOR` times as long as of the one before. */
  readonly levels: readonly Float32Array[];
}

const FACTOR = 4;
/** Seconds. */
const STEP = 0.005;

export function peaksOf(channels: readonly Float32Array[], sampleRate: number): Peaks {
  const length = channels[0]?.length ?? 0;
  const count = Math.max(1, Math.ceil(length / (STEP * sampleRate)));
  const finest = new Float32Array(count);
  for (const channel of channels) {
    for (let i = 0; i < length; i++) {
      const part = Math.min(count - 1, Math.floor(i / (STEP * sampleRate)));
      const value = Math.abs(channel[i] as number);
      if (value > (finest[part] as number)) finest[part] = value;
    }
  }
  const levels = [finest];
  for (let below = finest; below.length > FACTOR; ) {
    const level = new Float32Array(Math.ceil(below.length / FACTOR));
    below.forEach((value, i) => {
      const part = Math.floor(i / FACTOR);
      if (value > (level[part] as number)) level[part] = value;
    });
    levels.push(level);
    below = level;
  }
  return { step: STEP, levels };
}

/** The greatest amplitude from one time to another (in any order), seconds; 0 outside of the sound. */
export function peakBetween({ step, levels }: Peaks, from: number, to: number): number {
  const wide = Math.abs(to - from);
  let level = 0;
  while (level + 1 < levels.length && step * FACTOR ** (level + 1) <= wide) level++;
  const parts = levels[level] as Float32Array;
  const size = step * FACTOR ** level;
  const first = Math.max(0, Math.floor(Math.min(from, to) / size));
  const last = Math.min(parts.length - 1, Math.floor(Math.max(from, to) / size));
  let most = 0;
  for (let i = first; i <= last; i++) most = Math.max(most, parts[i] as number);
  return most;
}
