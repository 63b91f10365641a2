// The settings of "k by hand": their ranges, and how the page's address holds them.

// By name: what it starts at, its least and largest value, its step. Lengths are in millimetres, rates in rad/s and Hz.
export const RANGES = {
  k: [0.91, 0.5, 1.5, 0.01],
  rate: [16.5, 1, 30, 0.1],
  left: [100, 20, 200, 0.5],
  right: [91, 20, 200, 0.5],
  track: [400, 100, 1000, 1],
  believed_left: [100, 20, 200, 0.5],
  believed_right: [100, 20, 200, 0.5],
  believed_track: [400, 100, 1000, 1],
  hz: [10, 1, 100, 1],
};
export const METHODS = ['arc', 'midpoint', 'euler'];
// Rates that divide ten seconds into whole steps.
export const HERTZ = [1, 2, 5, 10, 20, 50, 100];
export const ANCHOR = 'k-by-hand';

export const defaults = () => ({
  ...Object.fromEntries(Object.entries(RANGES).map(([name, [value]]) => [name, value])), method: 'arc',
});

const nearest = (values, value) => values.reduce((best, each) => Math.abs(each - value) < Math.abs(best - value) ? each : best);

// What an address says of the settings; nonsense is left out, and what is beyond a range becomes its end. Null where it
// is about something else.
export function fromFragment(fragment) {
  const [anchor, query = ''] = fragment.replace(/^#/, '').split('?');
  if (anchor !== ANCHOR) return null;
  const found = defaults(), given = new URLSearchParams(query);
  for (const [name, [, least, most]] of Object.entries(RANGES)) {
    const text = given.get(name), value = Number(text);
    if (text !== null && text.trim() !== '' && Number.isFinite(value)) found[name] = Math.min(Math.max(value, least), most);
  }
  found.hz = nearest(HERTZ, found.hz);
  if (METHODS.includes(given.get('method'))) found.method = given.get('method');
  return found;
}

export const toFragment = settings => `#${ANCHOR}?${new URLSearchParams(settings)}`;
