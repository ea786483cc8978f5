"""What scripts beside this one know of their robot."""

JOINTS = ("left_wheel", "right_wheel")


def graph_id(name):
    return {"graph_path": f"/World/jetbot/{name}", "evaluator_name": "execution"}
