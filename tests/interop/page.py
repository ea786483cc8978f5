def packages():
    return {"rmw_cyclonedds_cpp": 1, "rmw_fastrtps_cpp": 1}


PAGE = None


def render(r):
    return ""
