# The front door: sets up, builds, tests, installs. Meson and Ninja do the work; see 'make help'.
BUILD  ?= build
PREFIX ?= /usr/local
DESTDIR ?=
MESON  ?= meson

.PHONY: all setup demo test install asan fuzz pictures clean help

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
	@echo "make clean     remove the build folders and demo/"
	@echo
	@echo "INSTALL=0      name missing packages instead of installing them"
