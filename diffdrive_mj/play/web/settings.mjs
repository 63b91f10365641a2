// A setting of the page, as text in its address and back. A setting is an object: names and numbers, as
// diffdrive_mj/play/setting.py has them, in SI units.

// The part of the address after the #: everything that the setting has, in its order.
export function toHash(setting) {
  return new URLSearchParams(Object.entries(setting).map(([name, value]) => [name, String(value)])).toString();
}

// The setting of an address: what it leaves out is that of the robot which it names, or of the first robot. What is no
// number stays text, and what is no setting stays too: the server says what is wrong with it.
export function fromHash(hash, openings) {
  const given = Object.fromEntries(new URLSearchParams(hash.replace(/^#/, "")));
  const opening = openings.find(({ robot }) => robot === given.robot) ?? openings[0];
  const setting = { ...opening };
  for (const [name, text] of Object.entries(given)) {
    const number = text.trim() === "" ? NaN : Number(text);
    setting[name] = typeof opening[name] === "number" && Number.isFinite(number) ? number : text;
  }
  return setting;
}

// The wheels of r_r = k r_l: with them the robot drives straight while the left wheel turns k times as fast as the
// right one.
export function compensated(setting) {
  const right = rounded(setting.k * setting.left_radius);
  return { ...setting, right_radius: right };
}

// A robot that believes what is true.
export function enlightened(setting) {
  const { left_radius, right_radius, track_width } = setting;
  return {
    ...setting,
    believed_left_radius: left_radius,
    believed_right_radius: right_radius,
    believed_track_width: track_width,
  };
}

// A number without the last digits, which products leave behind.
export function rounded(number) {
  return Number(number.toPrecision(12));
}
