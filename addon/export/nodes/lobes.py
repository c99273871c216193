"""A surface has room for so many lobes (csrc/material/material.h, SURFACE_LOBES); a tree with more
is cut where it costs least, and named. One node beyond the limit must not cost a render."""

LOBES = 8


def count(closure):
    """An upper bound of the lobes that the core makes of a closure."""
    if closure is None or "emission" in closure and "bsdf" not in closure:
        return 0
    if "bsdf" in closure:
        return _of_bsdf(closure)
    return sum(count(child) for child in _children(closure))


def _of_bsdf(closure):
    if closure["bsdf"] == "fluorescent":
        return 2
    if closure["bsdf"] != "principled":
        return 1
    metallic, transmission = closure["metallic"], closure["transmission"]
    dielectric = metallic != 1.0
    return (metallic != 0.0) + dielectric * ((transmission != 0.0) + 2 * (transmission != 1.0))


def _children(closure):
    return closure["mix"] if "mix" in closure else closure["add"]


def fit(closure):
    """The closure itself if it fits, or else with its deepest branches cut to their stronger
    side."""
    while count(closure) > LOBES:
        closure, changed = _cut(closure)
        if not changed:
            break
    return closure


def _cut(closure):
    """(closure, whether anything was cut): one branch point below, or else this one."""
    name = next((name for name in ("mix", "add") if closure and name in closure), None)
    if name is None:
        return closure, False
    children = list(closure[name])
    for i in sorted((0, 1), key=lambda i: -count(children[i])):
        children[i], changed = _cut(children[i])
        if changed:
            return dict(closure, **{name: children}), True
    factor = closure.get("factor", 0.0)
    stronger = 1 if not isinstance(factor, dict) and factor > 0.5 else 0
    return children[stronger], True
