# The front door: sets up, builds, tests, installs. Meson and Ninja do the work; see 'make help'.
BUILD  ?= build
PREFIX ?= /usr/local
DESTDIR ?=
HUNT_SCENES ?= 1000
MESON  ?= meson

.PHONY: all setup demo test install asan fuzz pictures docs measure page bench-check hunt clean help

all: setup
	@[ -f $(BUILD)/build.ninja ] || $(MESON) setup $(BUILD) --buildtype=release --prefix=$(PREFIX)
	@ninja -C $(BUILD)

setup:
	@packages/install.sh

demo: all
	@tools/demo.sh $(BUILD)

test: all
	@tools/test.sh $(BUILD)

install: all
	@$(MESON) configure $(BUILD) -Dprefix=$(PREFIX)
	@ninja -C $(BUILD)
	@DESTDIR=$(DESTDIR) $(MESON) install -C $(BUILD) --no-rebuild
	@[ -n "$(DESTDIR)" ] || [ "$$(id -u)" != 0 ] || ldconfig

asan: setup
	@tools/asan.sh $(BUILD)-asan

fuzz: setup
	@tools/fuzz.sh $(BUILD)-fuzz

pictures: all
	@tools/pictures.sh $(BUILD)

docs: all
	@tools/docs.py fill $(BUILD)
	@tools/docs.py check
	@tools/docs.py api $(BUILD)/docs
	@echo "docs: $(BUILD)/docs/api/index.html"

page: all
	@$(BUILD)/penumbra bench all -o $(BUILD)/page

measure: page
	@tools/docs.py measured $(BUILD)/page/report.json
	@tools/docs.py fill $(BUILD)

bench-check: all
	@tools/bench_check.py $(BUILD)

hunt: all
	@$(BUILD)/tests/hunt $(HUNT_SCENES)

clean:
	rm -rf $(BUILD) $(BUILD)-asan $(BUILD)-fuzz demo

help:
	@echo "make           install what is missing (Debian), build: $(BUILD)/penumbra"
	@echo "make demo      render a scene, its visibility and a comparison page into demo/"
	@echo "make test      run every test; the last line counts them"
	@echo "make install   library, headers, pkg-config file, man page, program (PREFIX, DESTDIR)"
	@echo "make asan      the tests under the address and undefined-behaviour sanitizers"
	@echo "make fuzz      fuzz the scene file and the importer (clang; FUZZ_SECONDS, default 600)"
	@echo "make pictures  render the pictures of the documents into docs/pictures/"
	@echo "make docs      fill in the documents' tables, look for dead links, make the API reference"
	@echo "make page      every method on every built-in scene: $(BUILD)/page/index.html"
	@echo "make measure   the same, and its figures into the documents"
	@echo "make bench-check  errors and relative costs against bench/check.json; says what got worse"
	@echo "make hunt      every method on everything, HUNT_SCENES random scenes (default 1000)"
	@echo "make clean     remove the build folders and demo/"
	@echo
	@echo "INSTALL=0      name missing packages instead of installing them"
