// The model that Python compiled, number for number, in MuJoCo's WebAssembly build.
//
// The XML gives the structure, in six digits. What was compiled here is compared with what was compiled there, field by
// field; then Python's numbers take the place of these, so that both step the same model.

const SIX_DIGITS = 1e-4;  // how far a field may be off its largest number before it is another model's

// The model of { xml, numbers, structure, option, statistic }; throws an Error that names the field that differs.
export function exactModel(mujoco, { xml, numbers, structure, option, statistic }) {
  const model = mujoco.MjModel.from_xml_string(xml);
  try {
    for (const [name, values] of Object.entries(structure)) compare(name, model[name], values, 0);
    for (const [name, values] of Object.entries(numbers)) {
      compare(name, model[name], values, SIX_DIGITS);
      model[name].set(values);
      compare(name, model[name], values, 0);
    }
    for (const [name, value] of Object.entries(option)) replace(`opt.${name}`, model.opt, name, value);
    for (const [name, value] of Object.entries(statistic)) replace(`stat.${name}`, model.stat, name, value);
  } catch (error) {
    model.delete();
    throw error;
  }
  return model;
}

function compare(name, here, there, tolerance) {
  if (here?.length !== there.length) {
    throw new Error(`${name}: ${here?.length ?? "no"} numbers here, ${there.length} in Python; another MuJoCo?`);
  }
  const slack = tolerance * Math.max(...there.map(Math.abs), 0);
  const k = there.findIndex((value, i) => !(Math.abs(Number(here[i]) - value) <= slack));
  if (k >= 0) throw new Error(`${name}[${k}] = ${here[k]} here, ${there[k]} in Python; another MuJoCo?`);
}

function replace(name, holder, key, value) {
  if (Array.isArray(value)) {
    holder[key].set(value);
    compare(name, holder[key], value, 0);
  } else {
    if (holder[key] === undefined) throw new Error(`${name}: is unknown here; another MuJoCo?`);
    holder[key] = value;
    compare(name, [holder[key]], [value], 0);
  }
}
