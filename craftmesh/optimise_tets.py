"""(placeholder)"""


def optimise_tets(nodes, tets, surface_nodes, internal, size):
    return nodes, tets, {}
