"""Votes: how much of a voxel's neighbourhood each grain holds."""

import numpy as np

from craftmesh.jit import kernel

# Grains that a voxel may choose from: those that come first in its neighbourhood, its own and near ones
# included. More than six meet within two voxels only in noise.
MOST_GRAINS = 6
NO_GRAIN = -1


@kernel
def votes(padded, inside, steps, weights, place, grain, share):
    """List the voxels with several grains around them; return how many there are.

    padded (n,): grain of each voxel, flat, < 0 for what is none; inside (k,): voxels of grains to look at;
    steps, weights (s,): the neighbourhood, its centre first. Row r of place (k,) gets a voxel, that of
    grain (k, MOST_GRAINS) the grains around it, NO_GRAIN for none, that of share their parts of the weight.
    """
    rows = 0
    for v in inside:
        found = 0
        total = 0.0
        for i in range(len(steps)):
            g = padded[v + steps[i]]
            if g < 0:
                continue
            total += weights[i]
            at = 0
            while at < found and grain[rows, at] != g:
                at += 1
            if at == MOST_GRAINS:
                continue
            if at == found:
                grain[rows, at] = g
                share[rows, at] = 0.0
                found += 1
            share[rows, at] += weights[i]
        if found > 1:
            place[rows] = v
            grain[rows, found:] = NO_GRAIN
            share[rows, :found] /= total
            rows += 1
    return rows


@kernel
def choices(padded, place, grain, share, price, best, lead, near, width):
    """Set for each row the grain with the most votes, prices added, and its lead over the voxel's own.

    place, grain, share: of `votes`; price (g,). near (g,) counts the rows where a grain is first or second
    and the two are less than `width` apart: the voxels that it would win or lose by a change of its price.
    """
    near[:] = 0
    for r in range(len(grain)):
        own = padded[place[r]]
        first, second, mine = -np.inf, -np.inf, -np.inf
        winner, next_one = own, NO_GRAIN
        for i in range(MOST_GRAINS):
            g = grain[r, i]
            if g == NO_GRAIN:
                break
            value = share[r, i] + price[g]
            if g == own:
                mine = value
            if value > first:
                second, next_one = first, winner
                first, winner = value, g
            elif value > second:
                second, next_one = value, g
        best[r] = winner
        lead[r] = first - mine
        if first - second < width:
            near[winner] += 1
            near[next_one] += 1
