#!/usr/bin/env bash
# shell_files.sh FLEXURA SHARE: what goes to /usr/share: manual pages of all commands, completion for bash, zsh and fish.
set -euo pipefail
flexura=$1 share=$2
rm -rf "$share"
mkdir -p "$share"/{man/man1,bash-completion/completions,zsh/vendor-completions,fish/vendor_completions.d}
page() { "$flexura" man "${@:2}" | gzip -9n >"$share/man/man1/$1.1.gz"; }
page flexura
for command in $("$flexura" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\)  .*/\1/p'); do page "flexura-$command" "$command"; done
"$flexura" completion bash >"$share/bash-completion/completions/flexura"
"$flexura" completion zsh >"$share/zsh/vendor-completions/_flexura"
"$flexura" completion fish >"$share/fish/vendor_completions.d/flexura.fish"
