// The page of a run. The 3D part is a separate frame.
import { connect } from "./connection.js";
import "./control.js";
import "./tree.js";
import "./robot.js";
import "./graphs.js";
import "./node.js";
import "./picture.js";
import "./plots.js";
import "./topics.js";
import "./findings.js";
import "./images.js";
import "./keyboard.js";
import "./log.js";
import "./help.js";
import "./recording.js";

connect();
