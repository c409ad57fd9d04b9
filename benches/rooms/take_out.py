"""Takes the trees of the rooms out of git directories: take_out.py FOLDER NAME=GITDIR...

NAME is dppm, rg, ppg or jg. Files are taken blob by blob, as a partial copy of a repository may lack some (`git
archive` stops at the first of these); absent ones are listed. The repository's folder `scenes` becomes FOLDER/NAME, or
where it has none, all of it.
"""

import os
import subprocess
import sys

SCENE_FILES = ('.xml', '.obj', '.serialized', '.ply', '.jpg', '.jpeg', '.png', '.exr', '.hdr', '.txt', '.bmp', '.tga')


def listed(gitdir):
    """Path and blob of every file of HEAD that belongs to scenes."""
    words = ['git', '--git-dir', gitdir, 'ls-tree', '-r', '-z', 'HEAD']
    tree = subprocess.run(words, capture_output=True, check=True).stdout
    files = []
    for line in tree.decode('utf-8', 'replace').split('\0'):
        if line:
            about, path = line.split('\t', 1)
            files.append((path, about.split()[2]))
    return [file for file in files if file[0].lower().endswith(SCENE_FILES)]


def blobs(gitdir, names):
    """The content of each blob; None if the copy lacks it. Nothing is fetched."""
    words = ['git', '--git-dir', gitdir, 'cat-file', '--batch']
    environment = {**os.environ, 'GIT_NO_LAZY_FETCH': '1'}
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment) as git:
        for name in names:
            git.stdin.write(name.encode() + b'\n')
            git.stdin.flush()
            answer = git.stdout.readline().split()
            if len(answer) < 3:
                yield None
                continue
            size = int(answer[2])
            yield git.stdout.read(size)
            git.stdout.read(1)


def is_inside(path):
    """A path that stays in its folder."""
    return not os.path.isabs(path) and '..' not in path.split('/')


def take(gitdir, target):
    files = listed(gitdir)
    scenes = [(path.removeprefix('scenes/'), blob) for path, blob in files if path.startswith('scenes/')]
    files = [(path, blob) for path, blob in scenes or files if is_inside(path)]
    absent, size = [], 0
    for (path, _), content in zip(files, blobs(gitdir, (blob for _, blob in files))):
        if content is None:
            absent.append(path)
            continue
        out = os.path.join(target, path)
        os.makedirs(os.path.dirname(out), exist_ok=True)
        with open(out, 'wb') as file:
            file.write(content)
        size += len(content)
    print(f'{target}: {len(files) - len(absent)} files, {size >> 20} MiB; {len(absent)} absent')
    for path in absent:
        print(f'  absent: {path}')


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    folder = sys.argv[1]
    for pair in sys.argv[2:]:
        name, _, gitdir = pair.partition('=')
        take(gitdir, os.path.join(folder, name))


if __name__ == '__main__':
    main()
