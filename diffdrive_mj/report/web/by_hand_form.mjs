// The form of "k by hand": sliders, examples, the drive beside them, and the page's address, by which a setting is shared.

import {drive, inWords} from '#web/by_hand.mjs';
import {Player} from '#web/player.mjs';
import {ANCHOR, defaults, fromFragment, HERTZ, RANGES, toFragment} from '#web/settings.mjs';

const UNITS = {k: '', rate: ' rad/s', hz: ' Hz'};
const DIGITS = {k: 2, rate: 1, hz: 0, track: 0, believed_track: 0};

const EXAMPLES = {
  'A slow left wheel': {right: 100},
  'Compensated: r_r = k r_l': {believed_right: 91},
  'Compensated, odometry unaware': {},
  'Radii believed 1 % too large': {k: 0.7, right: 100, believed_left: 101, believed_right: 101},
  'Track believed 2 % too wide': {k: 0.7, right: 100, believed_track: 408},
  'Euler at 2 Hz': {k: 0.7, right: 100, hz: 2, method: 'euler'},
};

export function startByHand(section) {
  const form = section.querySelector('form'), words = section.querySelector('[data-part=words]');
  let settings = fromFragment(location.hash) ?? defaults(), player, later;

  // The slider of the rate chooses among those that divide the drive.
  const toSlider = name => name === 'hz' ? HERTZ.indexOf(settings.hz) : settings[name];
  const fromSlider = (name, value) => name === 'hz' ? HERTZ[value] : value;

  function write() {
    for (const name of Object.keys(RANGES)) {
      const said = `${settings[name].toFixed(DIGITS[name] ?? 1)}${UNITS[name] ?? ' mm'}`;
      form.elements[name].value = toSlider(name);
      form.elements[name].setAttribute('aria-valuetext', said.trim());
      form.querySelector(`[data-of=${name}]`).textContent = said;
    }
    form.elements.method.value = settings.method;
  }

  function update({address = true, anew = false} = {}) {
    write();
    if (player) player.show(drive(settings), anew); else player = new Player(section.querySelector('.player'), [drive(settings)]);
    clearTimeout(later);
    // Not at every step of a slider: screen readers would not come to an end, and browsers limit changes of the address.
    later = setTimeout(() => {
      words.replaceChildren(...inWords(settings).map(text => Object.assign(document.createElement('p'), {textContent: text})));
      if (address) history.replaceState(null, '', toFragment(settings));
    }, words.textContent ? 150 : 0);
  }

  for (const [name, [, least, most, step]] of Object.entries(RANGES)) {
    const range = name === 'hz' ? {min: 0, max: HERTZ.length - 1, step: 1} : {min: least, max: most, step};
    Object.assign(form.elements[name], range);
    form.elements[name].addEventListener('input', event => {
      settings = {...settings, [name]: fromSlider(name, event.target.valueAsNumber)};
      update();
    });
  }
  form.elements.method.addEventListener('change', event => {
    settings = {...settings, method: event.target.value};
    update();
  });
  form.addEventListener('submit', event => event.preventDefault());
  section.querySelector('[data-part=examples]').append(...Object.entries(EXAMPLES).map(([name, changes]) => {
    const button = Object.assign(document.createElement('button'), {type: 'button', textContent: name});
    button.addEventListener('click', () => {
      settings = {...defaults(), ...changes};
      update({anew: true});
    });
    return button;
  }));
  addEventListener('hashchange', () => {
    const found = fromFragment(location.hash);
    if (!found) return;
    settings = found;
    update({address: false, anew: true});
    section.scrollIntoView();
  });
  update({address: false});
  if (location.hash.startsWith(`#${ANCHOR}?`)) section.scrollIntoView();
}
