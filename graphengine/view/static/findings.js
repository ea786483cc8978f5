// The findings of `graphrun check` in the scene's files, and errors in files that changed since.
import { on } from "./connection.js";
import { $, element, place, put } from "./elements.js";

on("findings", (findings) => {
  const errors = findings.filter((one) => one.severity === "error").length;
  put($("findings-tab"), `Findings ${findings.length}`);
  $("findings-tab").classList.toggle("alert", errors > 0);
  $("no-findings").hidden = findings.length > 0;
  $("findings").replaceChildren(...findings.map(line));
});

function line(finding) {
  const made = element("li", "", `finding ${finding.severity}`), head = element("p", "", "message");
  const code = element("span", `${finding.severity} ${finding.code}`, "code", { title: finding.title });
  head.append(code, " ", element("span", finding.message));
  made.append(head);
  if (finding.place) made.append(place(finding.place, finding.copy));
  if (finding.help) made.append(element("pre", finding.help, "help"));
  return made;
}
