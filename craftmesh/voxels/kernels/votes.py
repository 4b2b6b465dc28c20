"""Votes: fraction of a voxel's weighted neighbourhood that each grain fills."""

import numpy as np

from craftmesh.jit import kernel

# Largest number of grains counted per voxel: the first found from the centre of its neighbourhood outwards.
# More than six meet within two voxels only in noise.
MOST_GRAINS = 6
NO_GRAIN = -1


@kernel
def votes(padded, inside, steps, weights, place, grain, share):
    """Write a row for each voxel with several grains around it; return the number of rows.

    padded (n,): grain of each voxel, < 0 if it has none; inside (k,): voxels to test; steps, weights (s,):
    flat offsets and weights of the neighbourhood, its centre first. Output: place (k,), the voxel; grain
    (k, MOST_GRAINS), grains around it, then NO_GRAIN; share (k, MOST_GRAINS), their parts of the weight.
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
    """Write for each row the grain `best` of largest share + price, and its `lead` over the voxel's own.

    place, grain, share: from `votes`; price (g,). Output also near (g,): number of rows in which a grain is
    first or second by less than `width`, that is, of voxels that a small price change wins or loses.
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
