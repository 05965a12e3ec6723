# bash completion of onemapctl: to be installed as /usr/share/bash-completion/completions/onemapctl
_onemapctl() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command='' i
  local commands='status peers consensus map pose watch metrics cameras doctor snapshot save load record why unmerge merge team calibrate'
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${COMP_WORDS[i]} in
      --socket | --timeout) ((++i)) ;;
      -*) ;;
      *) command=${COMP_WORDS[i]} && break ;;
    esac
  done
  case $before in
    --socket | --file) COMPREPLY=($(compgen -f -- "$word")) && return ;;
    --timeout) return ;;
    --map) COMPREPLY=($(compgen -W 'local global' -- "$word")) && return ;;
    --view) COMPREPLY=($(compgen -W 'fit top follow plan front' -- "$word")) && return ;;
    --kind) COMPREPLY=($(compgen -W 'png glb plan' -- "$word")) && return ;;
  esac
  local options='--socket --json --timeout --help'
  case $command in
    '') COMPREPLY=($(compgen -W "$commands $options --version" -- "$word")) ;;
    pose) COMPREPLY=($(compgen -W "--follow $options" -- "$word")) ;;
    watch) COMPREPLY=($(compgen -W "POSE EVENT PEERS STATUS $options" -- "$word")) ;;
    record) COMPREPLY=($(compgen -W "start stop $options" -- "$word")) ;;
    snapshot) COMPREPLY=($(compgen -W "--map --view --kind $options" -- "$word")) ;;
    save | load) COMPREPLY=($(compgen -W "$options" -- "$word") $(compgen -f -- "$word")) ;;
    team) COMPREPLY=($(compgen -W "init show join --file --secret --force $options" -- "$word")) ;;
    calibrate) COMPREPLY=($(compgen -W '--from --out --baseline --images --json --help' -- "$word") $(compgen -f -- "$word")) ;;
    *) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
  esac
}
complete -F _onemapctl onemapctl
