"""Makes the wheel for `pip install .`: a build backend (PEP 517) that needs CMake, Ninja, pybind11-dev and nothing of PyPI.

A wheel is a zip archive of the package and three files about it (packaging.python.org, "Binary distribution format")."""
import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def version():
    return re.search(r"^project\(decid VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]


def build(tree):
    """Configures and builds the package alone, for this interpreter."""
    subprocess.run(["cmake", "-S", ROOT, "-B", tree, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release", "-D", "DECID_TESTS=OFF",
                    "-D", "DECID_TOOLS=OFF", "-D", "DECID_C=ON", "-D", "DECID_PYTHON_PACKAGE=ON",
                    "-D", "CMAKE_UNITY_BUILD=ON", "-D", "CMAKE_UNITY_BUILD_BATCH_SIZE=16",
                    "-D", "CMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG", "-D", f"Python_EXECUTABLE={sys.executable}"], check=True)
    subprocess.run(["cmake", "--build", tree, "--target", "decid_python", "-j", str(os.cpu_count())], check=True)


def digest(content):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def metadata():
    return (f"Metadata-Version: 2.1\nName: decid\nVersion: {version()}\nSummary: Identifies posture controllers from body sway "
            "on a tilting platform\nLicense: Apache-2.0\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
            "Provides-Extra: pandas\nRequires-Dist: pandas; extra == 'pandas'\n")


def get_requires_for_build_wheel(config_settings=None):
    return []


def tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def about():
    """The files about the wheel, but the list of all."""
    folder = f"decid-{version()}.dist-info"
    return {f"{folder}/METADATA": metadata(),
            f"{folder}/WHEEL": f"Wheel-Version: 1.0\nGenerator: decid\nRoot-Is-Purelib: false\nTag: {tag()}\n"}


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    for name, text in about().items():
        path = Path(metadata_directory) / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return path.parent.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """config_settings: {"build": a tree that is built already}, whose module must be of this interpreter."""
    tree = (config_settings or {}).get("build")
    if tree is None:
        tree = str(ROOT / "build/python")
        build(tree)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made).resolve()
        subprocess.run(["cmake", "--install", tree, "--component", "python", "--prefix", folder], check=True)
        content = {path.relative_to(folder).as_posix(): path.read_bytes()
                   for path in sorted(folder.rglob("*")) if path.is_file() and not path.is_symlink()}
        # An archive has no links: the library is stored under the name by which it is loaded.
        for path in folder.rglob("libdecid.so.*"):
            if path.is_symlink():
                content[path.relative_to(folder).as_posix()] = content.pop(path.resolve().relative_to(folder).as_posix())
    content |= {name: text.encode() for name, text in about().items()}
    record = f"decid-{version()}.dist-info/RECORD"
    lines = [f"{name},{digest(of)},{len(of)}" for name, of in content.items()] + [f"{record},,"]
    content[record] = ("\n".join(lines) + "\n").encode()
    wheel = f"decid-{version()}-{tag()}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, of in content.items():
            archive.writestr(name, of)
    return wheel
