// Drives to replay: the view, the time slider, the errors beside them, and the choice among drives and beliefs.

import {errorColour, palette} from '#web/colours.mjs';
import {degrees, quantity, seconds} from '#web/quantities.mjs';
import {errorAt, extent, largest, locate} from '#web/replay.mjs';
import {drawScene} from '#web/scene.mjs';
import {Stage} from '#web/stage.mjs';
import {Timeline} from '#web/timeline.mjs';

const STEPS = 500, FASTEST = 10;  // of the slider; of the play, in seconds for the whole drive

export class Player {
  // Into a place, from the page's template "player".
  constructor(place, replays) {
    place.replaceChildren(document.getElementById('player').content.cloneNode(true));
    this.place = place;
    this.part = Object.fromEntries([...place.querySelectorAll('[data-part]')].map(each => [each.dataset.part, each]));
    this.palette = () => palette(place);
    this.stage = new Stage(this.part.view, (context, camera) => this.paint(context, camera));
    this.timeline = new Timeline(this.part.errors, {onTime: t => this.goTo(t), palette: this.palette});
    this.listen();
    offer(this.part.drives, replays.map(replay => replay.title), 0, k => this.show(replays[k], true));
    this.show(replays[0], true);
  }

  listen() {
    const {part, stage} = this;
    part.time.max = STEPS;
    part.time.addEventListener('input', () => this.goTo(this.timeOf(part.time.valueAsNumber)));
    part.play.addEventListener('click', () => this.toggle());
    part.closer.addEventListener('click', () => stage.zoom(1.5));
    part.wider.addEventListener('click', () => stage.zoom(1 / 1.5));
    part.reset.addEventListener('click', () => stage.reset());
    part.view.addEventListener('keydown', event => {
      if (event.key !== ' ') return;
      event.preventDefault();
      this.toggle();
    });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.paintBar());
  }

  // A replay in place of another; the time stays unless it starts anew, the view if someone has moved it.
  show(replay, anew = false) {
    this.replay = replay;
    if (anew) this.chosen = 0;
    this.t = anew ? replay.t.at(-1) : Math.min(this.t, replay.t.at(-1));
    if (anew) this.offerBeliefs();
    if (anew || !this.stage.moved) this.stage.show(extent(replay));
    this.update();
  }

  offerBeliefs() {
    this.part.others.hidden = this.replay.beliefs.length < 2;
    offer(this.part.beliefs, this.replay.beliefs.map(belief => belief.name), this.chosen, k => {
      this.chosen = k;
      this.update();
    });
  }

  timeOf(step) {
    const [start, end] = [this.replay.t[0], this.replay.t.at(-1)];
    return start + step / STEPS * (end - start);
  }

  goTo(t) {
    this.t = t;
    this.update();
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.t >= this.replay.t.at(-1)) this.t = this.replay.t[0];
    this.before = undefined;
    if (this.playing) requestAnimationFrame(now => this.tick(now));
    this.label();
  }

  // As fast as it was driven, or faster where that takes long.
  tick(now) {
    if (!this.playing) return;
    const [start, end] = [this.replay.t[0], this.replay.t.at(-1)];
    const speed = Math.max(1, (end - start) / FASTEST);
    this.t = Math.min(this.t + speed * (now - (this.before ?? now)) / 1000, end);
    this.before = now;
    if (this.t >= end) this.playing = false;
    this.update();
    this.label();
    if (this.playing) requestAnimationFrame(later => this.tick(later));
  }

  label() {
    this.part.play.textContent = this.playing ? 'Pause' : 'Play';
  }

  update() {
    const {part, replay} = this, [start, end] = [replay.t[0], replay.t.at(-1)];
    const belief = replay.beliefs[this.chosen], off = errorAt(belief, locate(replay.t, this.t));
    part.time.value = Math.round((this.t - start) / (end - start) * STEPS);
    part.clock.textContent = seconds(this.t - start);
    part.position.textContent = quantity(off.position, 'm');
    part.heading.textContent = degrees(off.heading);
    part.time.setAttribute('aria-valuetext', `${seconds(this.t - start)}, ${part.position.textContent} off`);
    part.most.textContent = quantity(largest(belief.position_error), 'm');
    this.timeline.show(replay, belief, this.t);
    this.paintBar();
    this.stage.draw();
  }

  paint(context, camera) {
    if (!this.replay) return;
    const size = drawScene(context, camera, this.palette(), this.replay, this.chosen, this.t);
    this.part.size.textContent = size > 1.05 ? `robots drawn ${size.toPrecision(2)} times as large as they are` : 'robots to scale';
  }

  paintBar() {
    const context = this.part.bar.getContext('2d'), {width, height} = this.part.bar, {dark} = this.palette();
    for (let x = 0; x < width; x++) {
      context.fillStyle = errorColour(x / (width - 1), dark);
      context.fillRect(x, 0, 1, height);
    }
  }
}

let groups = 0;

// Names to choose from, below a heading; one alone needs no choice.
function offer(choice, names, chosen, choose) {
  const group = `choice-${groups++}`;
  choice.hidden = names.length < 2;
  choice.querySelector('div').replaceChildren(...names.map((name, k) => {
    const label = document.createElement('label'), input = document.createElement('input');
    Object.assign(input, {type: 'radio', name: group, checked: k === chosen});
    input.addEventListener('change', () => choose(k));
    label.append(input, name);
    return label;
  }));
}
