# The add-on's zip: Python, shaders, the core and the libraries that it needs. Installs in Blender 3.4 to 5.x.
.PHONY: addon
addon: build/stokes-addon.zip ## build build/stokes-addon.zip
build/stokes-addon.zip: build/stokes addon/pack.py $(shell find addon shaders -name "*.py" -o -name "*.json" -o -name "*.toml" -o -name "*.glsl")
	$(PYTHON) addon/pack.py build/stokes $(OCIO) $@
