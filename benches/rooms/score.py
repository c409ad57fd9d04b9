"""Scores an estimate of a room against its truth; any program's.

    score.py TRUTH --result FOLDER                                   a result of `unrender recover`, or
    score.py TRUTH --albedo A.exr --roughness R.exr [--statuses S.json]     maps of the photograph's size, as those of
                                                                     the truth (truth.py)
    [--picture NAME=FILE.exr]...   re-renderings: photo, new_view, new_light
    [--forward NAME=FILE.exr]...   renderings at the true materials: photo, new_view, new_light
    [--out score.json]

S.json has an object by group: {"WoodFloor": {"status": "recovered"}}. Nothing is rescaled. Of albedo and roughness:
-10 log10 of the mean squared error over the scored pixels. A group is wrong where the root mean square error of its
albedo is above 0.05, and told where its status is not `recovered`. Pictures are compared as sRGB at one exposure.
"""

import argparse
import json
import os

import engine

engine.start('scalar_rgb')
import estimate
import numpy as np
import pictures
from truth import Truth

VERSION = 2
# The root mean square error of albedo from which a group counts as wrong: a clearly visible difference.
WRONG = 0.05
# Groups of fewer scored pixels are not counted one by one.
FEWEST = 4
BLOCK = 4


def materials(truth, albedo, roughness, statuses):
    """The scores of the maps, and of each group."""
    scored = truth.scored.copy()
    for name, about in statuses.items():
        # What the solver was given.
        if about.get('status') in ('known', 'ignored') and name in truth.names:
            scored &= ~truth.pixels_of(name)
    true_albedo, true_roughness = truth.picture('albedo'), truth.picture('roughness')[..., 0]
    square = ((albedo - true_albedo) ** 2).mean(2)
    total = square[scored].sum()
    rows = []
    for listed in truth.about['groups']:
        name = listed['name']
        inside = scored & truth.pixels_of(name)
        count = int(inside.sum())
        if count < FEWEST:
            continue
        about = statuses.get(name, {})
        rms = float(np.sqrt(square[inside].mean()))
        rows.append({
            'group': name, 'pixels': count, 'kind': listed['kind'], 'textured': listed['textured'],
            'status': about.get('status', 'recovered'), 'hypothesis': about.get('hypothesis'),
            'albedo': rounded(albedo[inside].mean(0)), 'true_albedo': rounded(true_albedo[inside].mean(0)),
            'roughness': round(float(roughness[inside].mean()), 3),
            'true_roughness': round(float(true_roughness[inside].mean()), 3),
            'rms': rms, 'share': float(square[inside].sum() / max(total, 1e-12)),
            'wrong': rms > WRONG, 'told': about.get('status', 'recovered') != 'recovered',
        })
    rows.sort(key=lambda row: -row['share'])
    return {
        'pixels': int(scored.sum()),
        'albedo_db': pictures.db(square[scored].mean()),
        'roughness_db': pictures.db(((roughness - true_roughness)[scored] ** 2).mean()),
        'silent_share': sum(row['share'] for row in rows if not row['told']),
        'groups': len(rows),
        'wrong': sum(row['wrong'] for row in rows),
        'wrong_and_told': sum(row['wrong'] and row['told'] for row in rows),
        'right_and_told': sum(not row['wrong'] and row['told'] for row in rows),
        'rows': rows,
    }


def rounded(values):
    return [round(float(value), 3) for value in values]


def usable(truth, name):
    """The pixels of a picture that count: no glass, lamps or cut-outs."""
    return truth.picture('scored_new_view' if name == 'new_view' else 'scored')[..., 0] > 0.5


def blocks(picture, counts):
    """Sums of squares of pixels."""
    height, width = (size // BLOCK * BLOCK for size in counts.shape)
    kept = (picture * counts[..., None])[:height, :width]
    return kept.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).sum((1, 3))


def picture(truth, name, path):
    """How far a re-rendering is from the truth's picture."""
    ours, true = pictures.read(path), truth.picture(name)
    counts = usable(truth, name)
    white = truth.about['exposure']
    if name == 'new_light':
        # A photographer would set the exposure anew.
        white = float(np.quantile(true[counts].max(1), 0.98))
    code = lambda values: pictures.srgb(values / white)
    a, b = blocks(ours, counts), blocks(true, counts)
    seen = b.sum(2) > 0
    return {
        'psnr': pictures.db(((code(ours) - code(true))[counts] ** 2).mean()),
        'median': float(np.median(np.abs(a - b)[seen].sum(1) / b[seen].sum(1))),
        'mean': float(ours[counts].mean() / true[counts].mean()),
    }


def forward(truth, name, path):
    """Our rendering of the true materials over Mitsuba's: of the picture and of each group."""
    ours, true = pictures.read(path), truth.picture(name)
    counts, group = usable(truth, name), truth.groups_of(name)
    rows = []
    for number, listed in enumerate(truth.about['groups']):
        inside = counts & (group == number)
        if inside.sum() < FEWEST or true[inside].mean() <= 0:
            continue
        level = true[inside].mean()
        spread = (ours - true)[inside].mean(1).std() / np.sqrt(inside.sum())
        rows.append({'group': listed['name'], 'pixels': int(inside.sum()), 'kind': listed['kind'],
                     'ratio': float(ours[inside].mean() / level), 'std': float(spread / level)})
    rows.sort(key=lambda row: -row['pixels'])
    return {'mean': float(ours[counts].mean() / true[counts].mean()), 'rows': rows}


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument('truth')
    parser.add_argument('--result')
    parser.add_argument('--albedo')
    parser.add_argument('--roughness')
    parser.add_argument('--statuses')
    parser.add_argument('--picture', action='append', default=[])
    parser.add_argument('--forward', action='append', default=[])
    parser.add_argument('--out')
    return parser.parse_args()


def main():
    asked = arguments()
    truth = Truth(asked.truth)
    score = {'version': VERSION, 'room': truth.about['room']}
    if asked.result:
        score.update(materials(truth, *estimate.maps(truth, asked.result)))
    elif asked.albedo:
        statuses = {}
        if asked.statuses:
            with open(asked.statuses) as file:
                statuses = json.load(file)
        maps = pictures.read(asked.albedo), pictures.read(asked.roughness)[..., 0]
        score.update(materials(truth, *maps, statuses))
    for kind, rate, given in (('pictures', picture, asked.picture), ('forward', forward, asked.forward)):
        pairs = [each.split('=', 1) for each in given]
        score[kind] = {name: rate(truth, name, path) for name, path in pairs}
    text = json.dumps(score, indent=1)
    if asked.out:
        os.makedirs(os.path.dirname(os.path.abspath(asked.out)), exist_ok=True)
        with open(asked.out, 'w') as file:
            file.write(text)
    else:
        print(text)


if __name__ == '__main__':
    main()
