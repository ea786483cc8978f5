// Explains why a robot stands still: one sentence, and its evidence.
import { command } from "./connection.js";
import { button, element, put } from "./elements.js";

export function whyPart(robot) {
  const part = element("div", "", "", { id: "why" }), sentence = element("p", "", "sentence", { role: "status" });
  const evidence = element("details"), lines = element("ul");
  evidence.append(element("summary", "evidence"), lines);
  evidence.hidden = true;
  const explain = async () => {
    const { result, error } = await command("why", { robot }, true);
    put(sentence, error ?? result.sentence);
    lines.replaceChildren(...(result?.evidence ?? []).map((line) => element("li", line)));
    evidence.hidden = !lines.childElementCount;
  };
  part.append(button("Why does it stand?", explain), sentence, evidence);
  return part;
}
